// A network small enough for scalar loops and finite differences. Free of LibTorch.
#pragma once

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

}  // namespace ld
