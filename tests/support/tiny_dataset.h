// A data set of small random frames, made in a moment: for tests of what reads data sets, not of how pictures
// look.
#pragma once

#include <filesystem>
#include <string>

#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "tests/support/random_frame.h"

namespace ld {

/// Writes `train` + 1 validation + 1 test frames and the manifest.
inline void write_tiny_dataset(const std::filesystem::path& folder, int train, int size = 16, int spp = 2) {
  std::filesystem::create_directories(folder);
  Manifest manifest;
  for (int i = 0; i < train + 2; ++i) {
    ManifestFrame entry;
    entry.name = "frame_" + std::to_string(i);
    entry.split = i < train ? "train" : (i == train ? "validation" : "test");
    entry.index = i;
    const Frame frame = random_frame(size, size, spp, static_cast<uint32_t>(i));
    write_frame(frame_path(folder, entry.name), frame);
    write_image(reference_path(folder, entry.name), mean_radiance(frame));
    manifest.frames.push_back(entry);
  }
  add_to_manifest(folder, manifest);
}

/// The keys of a config that make training take milliseconds a step.
inline std::string tiny_network_yaml() {
  return "network:\n"
         "  kernel_size: 3\n"
         "  sample_reducer: [4, 4]\n"
         "  sample_partitioner: [4]\n"
         "  kernel_generator: [4]\n"
         "  unet: {encoder: [[4], [4]], bottleneck: [4], decoder: [[4], [4]], context: 4}\n";
}

}  // namespace ld
