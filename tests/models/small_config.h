// A network small enough for scalar loops and finite differences. Free of LibTorch.
#pragma once

#include "models/check_network.h"
#include "models/network_config.h"

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
  config.super_resolution.convolutions = {6, 5};
  config.super_resolution.denoiser = 4;
  return config;
}

/// All networks whose light passes through a filter, so that it stays within that of the samples.
inline std::vector<std::string> networks_that_filter() {
  std::vector<std::string> names;
  for (const std::string& name : network_names())
    if (network_traits(name).filter != Filter::none) names.push_back(name);
  return names;
}

/// A small network that makes the light itself.
inline NetworkConfig small_recurrent_config() {
  NetworkConfig config = small_config();
  config.name = "recurrent";
  config.features = {"normal", "depth", "roughness", "albedo", "specular", "emission"};
  config.unet.upsampling = "nearest";
  return config;
}

}  // namespace ld
