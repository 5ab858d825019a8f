// The layered denoiser of [MH20] (figure 2, section 3, appendix A), network name "layer".
#pragma once

#include "models/networks/layered_network.h"

namespace ld {

class LayerNetwork : public LayeredNetwork {
 public:
  explicit LayerNetwork(const NetworkConfig& config);

 private:
  torch::Tensor denoise(const NetworkInput& input, NetworkState& state) override;
  Kernels make_kernels(const NetworkInput& input) override;

  std::shared_ptr<KernelGenerator> kernel_generator_;
};

}  // namespace ld
