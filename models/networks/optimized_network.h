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

  /// lambda_0 = e^3 / (e^3 + levels - 1), whatever the picture.
  void begin_sharp() override;

 private:
  torch::Tensor denoise(const NetworkInput& input, NetworkState& state) override;
  Kernels make_kernels(const NetworkInput& input) override;
  torch::Tensor blended(const torch::Tensor& logits, const std::vector<torch::Tensor>& pictures,
                        const std::vector<torch::Tensor>& received) const;
  torch::Tensor upscale(const torch::Tensor& coarse, int64_t level, const torch::Tensor& fine) const;
  torch::Tensor received(const torch::Tensor& pixels) const;

  std::vector<std::shared_ptr<KernelGenerator>> kernel_generators_;  // finest first
};

}  // namespace ld
