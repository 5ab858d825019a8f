// What the networks on pixel aggregates share ([MH20] section 5 and appendix B): mean and variance of the
// features enter the sample reducer, one kernel a pixel filters the mean radiance.
#pragma once

#include "models/context_network.h"
#include "models/kernel_generator.h"

namespace ld {

class PixelNetwork : public ContextNetwork {
 protected:
  explicit PixelNetwork(const NetworkConfig& config);

 private:
  torch::Tensor denoise(NetworkInput input) override;

  /// embedding [B, 1, E, H, W], context [B, C, H, W], log_n [B, H, W] (0, or -inf for a pixel without
  /// samples), radiance [B, 3, H, W] -> [B, 3, H, W].
  virtual torch::Tensor filter(const FullyConnectedWeights& generator, const torch::Tensor& embedding,
                               const torch::Tensor& context, const torch::Tensor& log_n,
                               const torch::Tensor& radiance) const = 0;

  std::shared_ptr<KernelGenerator> kernel_generator_;
};

}  // namespace ld
