// A network small enough for scalar loops and finite differences, and random input for any configuration.
#pragma once

#include "frame/schema.h"
#include "models/network.h"
#include "tests/support/tensors.h"

namespace ld {

inline NetworkConfig small_config() {
  NetworkConfig config;
  config.features = {"radiance", "normal", "depth"};
  config.kernel_size = 3;
  config.sample_reducer = {6, 5};
  config.sample_partitioner = {6};
  config.kernel_generator = {8};
  config.unet.encoder = {{4, 5}, {6}};
  config.unet.bottleneck = {7};
  config.unet.decoder = {{6}, {5, 4}};
  config.unet.context = 3;
  return config;
}

/// Samples of which about a quarter are masked, and a pixel without any.
inline NetworkInput random_input(const NetworkConfig& config, int64_t b, int64_t s, int64_t h, int64_t w,
                                 torch::ScalarType type, uint32_t seed = 1) {
  const torch::Tensor valid = random_valid(b, s, h, w, seed);
  const torch::Tensor radiance = random_uniform({b, s, 3, h, w}, seed + 1, 0, 4) * valid;
  const torch::Tensor features =
      random_normal({b, s, channel_count(config.features), h, w}, seed + 2) * valid;
  return {features.to(type), radiance.to(type), valid.to(type)};
}

/// Xavier weights, and biases that are not 0, in the wanted type.
inline std::shared_ptr<Network> small_network(const NetworkConfig& config, torch::ScalarType type,
                                              uint64_t seed = 1) {
  const auto network = make_network(config);
  initialise_xavier(*network, seed);
  network->to(type);
  const torch::NoGradGuard no_gradient;
  uint32_t index = 100;
  for (auto& parameter : network->parameters())
    if (parameter.dim() == 1) parameter.copy_(random_normal(parameter.sizes(), index++, 0.3));
  return network;
}

}  // namespace ld
