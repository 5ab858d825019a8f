// What every denoising network takes and gives, and the registry that makes one from its configuration.
#pragma once

#include <torch/torch.h>

#include <memory>
#include <string>
#include <vector>

#include "models/network_config.h"

namespace ld {

/// A batch of frames or crops, float32 or float64.
struct NetworkInput {
  torch::Tensor features;  // [B, S, F, H, W] encoded (frame/schema.h), channels in the order of
                           // NetworkConfig::features; 0 where a sample is not valid
  torch::Tensor radiance;  // [B, S, 3, H, W] linear, >= 0, finite; 0 where a sample is not valid
  torch::Tensor valid;     // [B, S, 1, H, W] 1 for a sample that was drawn, 0 for a missing or masked one
};

/// A network of [MH20]: linear radiance samples and features in, the linear denoised image [B, 3, H, W] out.
class Network : public torch::nn::Module {
 public:
  explicit Network(NetworkConfig config) : config_(std::move(config)) {}

  /// Any H and W from 1. Throws Error when a shape does not fit the configuration.
  virtual torch::Tensor forward(const NetworkInput& input) = 0;

  const NetworkConfig& config() const { return config_; }

 private:
  NetworkConfig config_;
};

/// Throws UsageError for an unknown name or sizes that do not fit together. Weights are uninitialised until
/// initialise_xavier() or a weight file fills them.
std::shared_ptr<Network> make_network(const NetworkConfig& config);

std::vector<std::string> network_names();

/// Xavier/Glorot (2010) uniform weights, biases zero, as [MH20] section 4; the same bits for the same seed.
void initialise_xavier(Network& network, uint64_t seed);

}  // namespace ld
