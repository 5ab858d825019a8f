// The interactive variant of [MH20] section 6 and figure 9: a cascade of small kernels at falling resolutions
// in place of a large one. Network name "optimized".
#pragma once

#include "models/kernel_generator.h"
#include "models/networks/layer_pyramid.h"
#include "models/networks/layered_network.h"

namespace ld {

/// The layers of full resolution are scaled down by 2 per level. Each level has a kernel generator, which
/// reads the layer embeddings of its resolution and what the U-net's decoder knows there (the context at full
/// resolution), and is filtered and composited on its own to the picture G_i. These are blended
/// (models/level_blend.h) by further outputs of the full resolution's generator for layer 0.
class OptimizedNetwork : public LayeredNetwork {
 public:
  explicit OptimizedNetwork(const NetworkConfig& config);

  /// lambda_0 = e^3 / (e^3 + levels - 1) where the other numbers of their layer add nothing.
  void begin_sharp() override;

 private:
  torch::Tensor denoise(const NetworkInput& input, NetworkState& state) override;
  Kernels make_kernels(const NetworkInput& input) override;

  std::vector<std::shared_ptr<KernelGenerator>> kernel_generators_;  // finest first
};

}  // namespace ld
