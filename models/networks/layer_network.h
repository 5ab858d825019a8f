// The layered denoiser of [MH20] (figure 2, section 3, appendix A), network name "layer".
#pragma once

#include "models/networks/layered_network.h"

namespace ld {

class LayerNetwork : public LayeredNetwork {
 public:
  explicit LayerNetwork(const NetworkConfig& config);

 protected:
  /// The layers filtered and composited, before the texture comes back.
  struct Composited {
    torch::Tensor light;    // all forms of radiance that the input has [B, C, H, W]
    torch::Tensor context;  // C_xy [B, C, H, W]
  };
  Composited composited(const NetworkInput& input) const;

 private:
  torch::Tensor denoise(const NetworkInput& input, NetworkState& state) override;
  Kernels make_kernels(const NetworkInput& input) override;

  std::shared_ptr<KernelGenerator> kernel_generator_;
};

}  // namespace ld
