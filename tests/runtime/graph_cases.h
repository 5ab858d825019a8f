// What graphs are tried on: networks of all kinds, and frames with holes.
#pragma once

#include "tests/models/small_network.h"
#include "tests/support/random_frame.h"

namespace ld {

/// A frame of which some samples are missing, the first pixel and a ninth of the picture have none, and the
/// light spans ten octaves.
inline Frame uneven_frame(int width, int height, int spp) {
  Frame frame = random_frame(width, height, spp, 7);
  RandomStream random(8, RandomPurpose::test);
  for (int s = 0; s < spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      const float light = std::exp2(10 * random.uniform(0.0F, 1.0F) - 5);
      for (int c = 0; c < 3; ++c) frame.plane(s, c)[p] *= light;
      for (const char* name : {"albedo", "specular"})
        for (int c = 0; c < 3; ++c) {
          float& value = frame.plane(s, find_feature(name).offset + c)[p];
          value = std::max(value, 0.0F);
        }
      const int x = int(p) % width, y = int(p) / width;
      const bool hole = x > width / 3 && x <= 2 * width / 3 && y > height / 3 && y <= 2 * height / 3;
      if (p != 0 && !hole && random.uniform(0.0F, 1.0F) > 0.2F) continue;
      frame.valid_plane(s)[p] = 0;
      for (int c = 0; c < kSampleChannels; ++c) frame.plane(s, c)[p] = 0;
    }
  return frame;
}

/// What a failing test calls one of the configurations.
inline std::string full_title(const NetworkConfig& config) {
  return title(config) + ", " + config.unet.upsampling + ", " + std::to_string(config.levels) + " levels" +
         (config.means ? ", of means" : "") + (config.exposure_normalisation ? ", exposed" : "");
}

/// Of every network: as small_network.h has them, some with nearest upsampling, with other layers and levels,
/// of means, and all of them exposed.
inline std::vector<NetworkConfig> graph_configs() {
  std::vector<NetworkConfig> configs = every_config();
  for (NetworkConfig config : std::vector<NetworkConfig>(configs))
    if (has_layers(config)) {
      config.unet.upsampling = "nearest";
      config.layers = 3;
      configs.push_back(config);
    }
  for (NetworkConfig config : std::vector<NetworkConfig>(configs))
    if (network_traits(config.name).has_levels)
      for (const int64_t levels : {1, 2}) {
        config.levels = levels;
        configs.push_back(config);
      }
  for (NetworkConfig config : every_config())
    if (network_traits(config.name).has_levels) {
      config.unet.encoder = {{4, 5}, {6}, {5}, {4}};
      config.unet.decoder = {{4}, {5}, {6}, {5, 4}};
      config.levels = 5;
      configs.push_back(config);
    }
  for (NetworkConfig config : std::vector<NetworkConfig>(configs))
    if (works_on_pixels(config)) {
      config.means = true;
      configs.push_back(config);
    }
  for (NetworkConfig config : std::vector<NetworkConfig>(configs)) {
    if (!may_be_exposed(config)) continue;
    config.exposure_normalisation = true;
    configs.push_back(config);
  }
  return configs;
}

}  // namespace ld
