#include "ops/fully_connected.h"

#include <ATen/Parallel.h>

#include <algorithm>

#include "core/error.h"
#include "ops/composition.h"
#include "ops/expect_tensor.h"
#include "ops/network_tiles.h"

namespace ld {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

constexpr int64_t kGroups =
    16;  // partial sums of the weights' gradient; fixed, so that threads change no bit
constexpr int64_t kForwardPixels = 192;      // of a tile: whole panels of every vector width
constexpr int64_t kBackwardFloats = 524288;  // of a tile with its gradients: the L2 cache of a recent core
constexpr int64_t kBackwardPixels = 768;     // more would not make its sums over pixels any cheaper

/// The arguments with pixels flattened: x [B, S, X, P], shared [B, Y, P] or undefined.
struct TiledArguments {
  Tensor x, shared;
  TileNetwork network;
  int64_t tile;

  TiledArguments(Tensor x_in, Tensor shared_in, const variable_list& weights, const variable_list& biases,
                 TileNetwork::Last last, bool backward)
      : x(std::move(x_in)),
        shared(std::move(shared_in)),
        network(tile_network(weights, biases, x.size(2), last, backward)) {
    tile = backward ? std::clamp<int64_t>(kBackwardFloats / network.scratch_width(true) / 48 * 48, 96,
                                          kBackwardPixels)
                    : kForwardPixels;
    tile = std::min(tile, padded(x.size(3)));
  }

  int64_t tiles() const { return (x.size(3) + tile - 1) / tile; }
  int64_t items() const { return x.size(0) * tiles(); }
};

/// The pixels of one item of work, and the planes of tensors at them.
struct Tile {
  int64_t b, begin, count;
  Tile(const TiledArguments& problem, int64_t item)
      : b(item / problem.tiles()),
        begin(item % problem.tiles() * problem.tile),
        count(std::min(problem.tile, problem.x.size(3) - begin)) {}
  /// Of [B, C, P], or sample s of [B, S, C, P].
  float* of(const Tensor& t) const { return t.data_ptr<float>() + b * t.stride(0) + begin; }
  float* of(const Tensor& t, int64_t s) const { return of(t) + s * t.stride(1); }
};

void stage_shared(const TiledArguments& problem, const Tile& tile, TileNetwork::Scratch& scratch) {
  if (problem.shared.defined())
    stage({tile.of(problem.shared), problem.shared.size(1), problem.shared.size(2)}, tile.count,
          scratch.shared, scratch.pitch);
  problem.network.begin_tile(scratch, tile.count);
}

void stage_sample(const TiledArguments& problem, const Tile& tile, int64_t s, TileNetwork::Scratch& scratch) {
  stage({tile.of(problem.x, s), problem.x.size(2), problem.x.size(3)}, tile.count, scratch.x, scratch.pitch);
}

/// Sums of one group of tiles towards the gradients of the weights.
struct Gradients {
  variable_list weights, biases;
  TileNetwork::Sums sums;
  Gradients() = default;
  Gradients(const variable_list& w, const variable_list& b) {
    for (size_t i = 0; i < w.size(); ++i) {
      weights.push_back(at::zeros(w[i].sizes(), w[i].options()));
      biases.push_back(at::zeros(b[i].sizes(), b[i].options()));
      sums.weights.push_back(weights.back().data_ptr<float>());
      sums.biases.push_back(biases.back().data_ptr<float>());
    }
  }
};

class FullyConnected : public torch::autograd::Function<FullyConnected> {
 public:
  static Tensor forward(AutogradContext* context, const Tensor& x, const c10::optional<Tensor>& shared,
                        at::TensorList weights, at::TensorList biases, bool activate_last, double bound) {
    variable_list to_save = {x, shared.value_or(Tensor())};
    to_save.insert(to_save.end(), weights.begin(), weights.end());
    to_save.insert(to_save.end(), biases.begin(), biases.end());
    context->save_for_backward(to_save);
    context->saved_data["activate_last"] = activate_last;
    context->saved_data["bound"] = bound;
    const TiledArguments problem(x, shared.value_or(Tensor()), weights.vec(), biases.vec(),
                                 {activate_last, float(bound)}, false);
    const TileNetwork& network = problem.network;
    const Tensor out = at::empty({x.size(0), x.size(1), network.outputs(), x.size(3)}, x.options());
    at::parallel_for(0, problem.items(), 1, [&](int64_t first, int64_t last) {
      TileNetwork::Scratch scratch = network.make_scratch(problem.tile, false);
      for (int64_t item = first; item < last; ++item) {
        const Tile tile(problem, item);
        stage_shared(problem, tile, scratch);
        for (int64_t s = 0; s < x.size(1); ++s) {
          stage_sample(problem, tile, s, scratch);
          network.forward(scratch, tile.count);
          unstage(scratch.a.back(), scratch.pitch, network.outputs(), tile.count, tile.of(out, s), x.size(3));
        }
      }
    });
    return out;
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const auto count = int64_t(saved.size() - 2) / 2;
    const variable_list weights(saved.begin() + 2, saved.begin() + 2 + count);
    const variable_list biases(saved.begin() + 2 + count, saved.end());
    const TileNetwork::Last ending = {context->saved_data["activate_last"].toBool(),
                                      float(context->saved_data["bound"].toDouble())};
    const TiledArguments problem(saved[0], saved[1], weights, biases, ending, true);
    const Tensor gradient = gradients[0].contiguous();
    Tensor x_gradient, shared_gradient;
    if (problem.x.requires_grad()) x_gradient = at::empty_like(problem.x);
    if (problem.shared.defined() && problem.shared.requires_grad())
      shared_gradient = at::empty_like(problem.shared);

    const int64_t groups = std::min(problem.items(), kGroups);
    std::vector<Gradients> sums(size_t(std::max<int64_t>(groups, 1)));
    sums[0] = Gradients(weights, biases);
    at::parallel_for(0, groups, 1, [&](int64_t first, int64_t last) {
      TileNetwork::Scratch scratch = problem.network.make_scratch(problem.tile, true);
      for (int64_t group = first; group < last; ++group) {
        if (group > 0) sums[size_t(group)] = Gradients(weights, biases);
        for (int64_t item = problem.items() * group / groups; item < problem.items() * (group + 1) / groups;
             ++item)
          tile_backward(problem, Tile(problem, item), gradient, x_gradient, shared_gradient,
                        sums[size_t(group)].sums, scratch);
      }
    });
    for (size_t group = 1; group < sums.size(); ++group)
      for (size_t i = 0; i < size_t(count); ++i) {
        sums[0].weights[i].add_(sums[group].weights[i]);
        sums[0].biases[i].add_(sums[group].biases[i]);
      }

    variable_list result = {x_gradient, shared_gradient};
    result.insert(result.end(), sums[0].weights.begin(), sums[0].weights.end());
    result.insert(result.end(), sums[0].biases.begin(), sums[0].biases.end());
    result.resize(result.size() + 2);  // activate_last, bound
    return result;
  }

 private:
  /// Through all samples of a tile; x_gradient and shared_gradient may be undefined where not needed.
  static void tile_backward(const TiledArguments& problem, const Tile& tile, const Tensor& gradient,
                            const Tensor& x_gradient, const Tensor& shared_gradient,
                            const TileNetwork::Sums& sums, TileNetwork::Scratch& scratch) {
    const TileNetwork& network = problem.network;
    const int64_t plane = problem.x.size(3);
    stage_shared(problem, tile, scratch);
    for (int64_t s = 0; s < problem.x.size(1); ++s) {
      stage_sample(problem, tile, s, scratch);
      network.forward(scratch, tile.count);
      stage({tile.of(gradient, s), network.outputs(), plane}, tile.count, scratch.g.back(), scratch.pitch);
      network.backward(scratch, tile.count, sums, x_gradient.defined());
      if (x_gradient.defined())
        unstage(scratch.x_gradient, scratch.pitch, problem.x.size(2), tile.count, tile.of(x_gradient, s),
                plane);
    }
    network.end_tile(scratch, tile.count, sums, shared_gradient.defined());
    if (shared_gradient.defined())
      unstage(scratch.shared_gradient, scratch.pitch, problem.shared.size(1), tile.count,
              tile.of(shared_gradient), plane);
  }
};

}  // namespace

Tensor fully_connected(const Tensor& x, const Tensor& shared, const FullyConnectedWeights& network,
                       bool activate_last) {
  const auto type = floating_type("fully_connected: x", x);
  expect_tensor("fully_connected: x", "[B, S, X, H, W]", x,
                {kAnySize, kAnySize, kAnySize, kAnySize, kAnySize}, type);
  int64_t inputs = x.size(2);
  if (shared.defined()) {
    expect_tensor("fully_connected: shared", "[B, Y, H, W]", shared,
                  {x.size(0), kAnySize, x.size(3), x.size(4)}, type);
    inputs += shared.size(1);
  }
  if (activate_last && network.bound > 0)
    fail("fully_connected: the last layer has both an activation and a bound, expected one of them");
  if (network.weights.empty() || network.weights.size() != network.biases.size())
    fail("fully_connected: {} weights and {} biases, expected as many of both and at least one",
         network.weights.size(), network.biases.size());
  for (size_t i = 0; i < network.weights.size(); ++i) {
    expect_tensor("fully_connected: weights", "[outputs, inputs]", network.weights[i], {kAnySize, inputs},
                  type);
    inputs = network.weights[i].size(0);
    expect_tensor("fully_connected: biases", "[outputs]", network.biases[i], {inputs}, type);
  }
  if (runs_composed(x)) return composed::fully_connected(x, shared, network, activate_last);
  c10::optional<Tensor> flat_shared;
  if (shared.defined())  // GCC takes a conditional expression for an uninitialised value here
    flat_shared = shared.contiguous().flatten(2);
  const FullyConnectedWeights plain = contiguous(network);
  return FullyConnected::apply(x.contiguous().flatten(3), flat_shared, at::TensorList(plain.weights),
                               at::TensorList(plain.biases), activate_last, plain.bound)
      .view({x.size(0), x.size(1), inputs, x.size(3), x.size(4)});
}

}  // namespace ld
