// A data set of short sequences whose pixels say which they are: for tests of what follows what.
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <string>
#include <vector>

#include "frame/frame_file.h"
#include "frame/manifest.h"

namespace ld {

/// The reference of the frame is x in red, y in green and `number` in blue. Its sample s has radiance (s + 1,
/// number, x), and something moves 16 pixels to the right since the frame before.
inline void write_numbered_frame(const std::filesystem::path& folder, const std::string& name, int number,
                                 int size, int spp) {
  Frame frame(size, size, spp);
  Image reference(size, size, 3);
  frame.features = {"radiance", "normal", "motion", "time", "flow"};
  frame.info.depth_scale = 1;
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x) {
      const float pixel[3] = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(number)};
      for (int c = 0; c < 3; ++c) reference.at(c, x, y) = pixel[c];
      for (int s = 0; s < spp; ++s) {
        const float radiance[3] = {static_cast<float>(s + 1), pixel[2], pixel[0]};
        for (int c = 0; c < 3; ++c) frame.plane(s, c)[y * size + x] = radiance[c];
        frame.plane(s, kFlowOffset)[y * size + x] = 16;
      }
    }
  write_frame(frame_path(folder, name), frame);
  write_image(reference_path(folder, name), reference);
}

/// Sequence q has as many frames as lengths[q] says, SPLIT_q_00, SPLIT_q_01, ... with the numbers 100 q, 100
/// q + 1, ...
inline void write_tiny_sequences(const std::filesystem::path& folder, const std::vector<int>& lengths,
                                 const std::string& split = "train", int size = 16, int spp = 2) {
  std::filesystem::create_directories(folder);
  Manifest manifest;
  for (size_t q = 0; q < lengths.size(); ++q)
    for (int i = 0; i < lengths[q]; ++i) {
      ManifestFrame entry;
      entry.name = fmt::format("{}_{}_{:02}", split, q, i);
      entry.split = split;
      entry.sequence = static_cast<int64_t>(q);
      entry.position = i;
      write_numbered_frame(folder, entry.name, 100 * static_cast<int>(q) + i, size, spp);
      manifest.frames.push_back(entry);
    }
  add_to_manifest(folder, manifest);
}

}  // namespace ld
