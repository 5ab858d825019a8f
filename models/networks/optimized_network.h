// The interactive variant of [MH20] section 6 and figure 9: a cascade of small kernels at falling resolutions
// in place of a large one. Network name "optimized".
#pragma once

#include "models/kernel_generator.h"
#include "models/networks/layer_pyramid.h"
#include "models/networks/layered_network.h"

namespace ld {

/// The layers of full resolution are scaled down by 2 per level. Each level has a kernel generator, which
/// reads the layer embeddings of its resolution and what the U-net's decoder knows there (the context at full
/// resolution), and is filtered and composited on its own to the picture G_i. The result is
///   sum_i lambda_i Upscale(G_i, 2^i)   (eq. 10),
/// with lambda_i from further outputs of the full resolution's generator for layer 0. The paper leaves them
/// free; here they are a softmax over the levels, because nothing else keeps a constant picture constant. A
/// level that received nothing at a pixel is left out of its sum. Upscaling is as in the U-net.
class OptimizedNetwork : public LayeredNetwork {
 public:
  explicit OptimizedNetwork(const NetworkConfig& config);

  int64_t memory_bytes(int64_t samples, int64_t height, int64_t width) const override;

  /// lambda_0 = e^3 / (e^3 + levels - 1), whatever the picture.
  void begin_sharp() override;

 private:
  struct Levels;  // what the levels come to, each at its resolution

  torch::Tensor denoise(const InputSource& input) override;
  Kernels make_kernels(const InputSource& input) override;
  Levels filter_levels(const InputSource& input) const;
  torch::Tensor blend_rows(const Levels& levels, int64_t begin, int64_t end, int64_t width) const;
  torch::Tensor upscale(const torch::Tensor& coarse, int64_t level, int64_t begin, int64_t end,
                        int64_t width) const;
  torch::Tensor received(const torch::Tensor& pixels) const;

  std::vector<std::shared_ptr<KernelGenerator>> kernel_generators_;  // finest first
};

}  // namespace ld
