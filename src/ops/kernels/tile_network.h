// A network of fully connected layers on a tile of pixels, all of it in the cache: what ops/fully_connected.h
// runs over pictures and ops/generated_filter.h feeds to the filters. Free of LibTorch.
#pragma once

#include <vector>

#include "ops/kernels/filter.h"

namespace ld {

/// Copies `pixels` of each plane to rows of `pitch` floats, and zeros up to padded(pixels).
void stage(const Planes& from, int64_t pixels, float* to, int64_t pitch);

/// Copies rows of a tile to planes `stride` apart.
void unstage(const float* from, int64_t pitch, int64_t rows, int64_t pixels, float* to, int64_t stride);

class TileNetwork {
 public:
  struct Layer {
    const float* weights;  // [outputs, inputs]
    const float* biases;   // [outputs]
    int64_t outputs, inputs;
  };
  /// What the last layer's results go through: nothing, leaky ReLU, or a bound (ops/fully_connected.h).
  struct Last {
    bool activated = false;
    float bound = 0;  // 0: none
  };
  /// The first layer reads x_inputs channels of x and then those that all x of a pixel share.
  TileNetwork(std::vector<Layer> layers, int64_t x_inputs, Last last, bool for_backward);

  int64_t x_inputs() const { return x_inputs_; }
  int64_t shared_inputs() const { return layers_[0].inputs - x_inputs_; }
  int64_t outputs() const { return layers_.back().outputs; }
  int64_t depth() const { return int64_t(layers_.size()); }

  /// Floats of scratch a pixel of a tile takes.
  int64_t scratch_width(bool backward) const;

  /// One thread's memory for a tile: rows of `pitch` floats.
  struct Scratch {
    Floats memory;
    int64_t pitch = 0;
    float *x = nullptr, *shared = nullptr,
          *shared_sum = nullptr;  // shared_sum: the first layer's shared part
    std::vector<float*> a;        // results of the layers
    std::vector<float*> g;        // gradients of the layers' sums
    float *x_gradient = nullptr, *first_gradient = nullptr, *shared_gradient = nullptr;
  };
  Scratch make_scratch(int64_t pixels, bool backward) const;
  /// One for each of so many threads, for forward() alone.
  std::vector<Scratch> make_scratches(int threads, int64_t pixels) const;

  /// `shared` (scratch.shared, or rows elsewhere that are aligned alike) -> scratch.shared_sum, once a tile.
  void begin_tile(Scratch& scratch, int64_t pixels, PlanarRow shared) const;
  void begin_tile(Scratch& scratch, int64_t pixels) const {
    begin_tile(scratch, pixels, {scratch.shared, scratch.pitch});
  }

  /// `x` (scratch.x, or rows elsewhere) -> scratch.a; the last layer goes to `out` [outputs] where that is
  /// given.
  void forward(Scratch& scratch, int64_t pixels, PlanarRow x, PlanarTarget out) const;
  void forward(Scratch& scratch, int64_t pixels, PlanarTarget out = {}) const {
    forward(scratch, pixels, {scratch.x, scratch.pitch}, out);
  }

  /// Where the gradients of weights and biases are summed.
  struct Sums {
    std::vector<float*> weights, biases;
  };
  /// After forward(): the gradient of the result is in scratch.g.back(). Adds to `sums`, adds the first
  /// layer's to scratch.first_gradient (zeroed by begin_tile), and writes scratch.x_gradient where wanted.
  void backward(Scratch& scratch, int64_t pixels, const Sums& sums, bool want_x) const;

  /// Once a tile, after all of its backward(): the shared part; writes scratch.shared_gradient where wanted.
  void end_tile(Scratch& scratch, int64_t pixels, const Sums& sums, bool want_shared) const;

 private:
  bool activated(int64_t layer) const { return layer + 1 < depth() || last_.activated; }

  std::vector<Layer> layers_;
  int64_t x_inputs_;
  Last last_;
  std::vector<PackedWeights> forward_, backward_;  // of x; shared ones apart
  std::vector<PackedWeights> shared_;              // forward and, for a backward pass, transposed
};

}  // namespace ld
