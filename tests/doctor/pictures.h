// Small rendered frames, and ways to spoil them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "core/threads.h"
#include "doctor/doctor.h"
#include "doctor/evidence.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "render/recipe/dataset_renderer.h"
#include "tests/support/temporary_folder.h"

namespace ld {

constexpr int kSize = 48;

struct Picture {
  ManifestFrame entry;
  Frame frame;
  Image reference;
};
using Pictures = std::vector<Picture>;

/// Eight rendered frames; the data set that every fault is put into.
inline Pictures render_pictures(const std::filesystem::path& folder, bool filter_guides = false) {
  Recipe recipe;
  recipe.resolution = {kSize, kSize};
  recipe.spp = 8;
  recipe.reference_spp = {64, 64, 64, 1};
  recipe.frames = {6, 1, 1, 0};
  recipe.filter_guides = filter_guides;
  render_dataset(recipe, folder, 0, 8, default_threads());
  Pictures pictures;
  for (const ManifestFrame& entry : read_manifest(folder).frames) {
    Picture& picture = pictures.emplace_back();
    picture.entry = entry;
    picture.entry.checksum = picture.entry.reference_checksum = "";
    Faults faults;
    picture.frame = read_frame(frame_path(folder, entry.name), {}, faults);
    picture.reference = read_image(reference_path(folder, entry.name));
  }
  return pictures;
}

inline Manifest write_pictures(const std::filesystem::path& folder, const Pictures& pictures) {
  Manifest manifest;
  for (const Picture& picture : pictures) {
    write_frame(frame_path(folder, picture.entry.name), picture.frame);
    write_image(reference_path(folder, picture.entry.name), picture.reference);
    manifest.frames.push_back(picture.entry);
  }
  return manifest;
}

inline Diagnosis examine(const Pictures& pictures) {
  const TemporaryFolder folder;
  const Manifest manifest = write_pictures(folder.path(), pictures);
  return examine_dataset(folder.path(), manifest, {default_threads(), 0});
}

inline std::string text_of(const Diagnosis& diagnosis) {
  std::string text;
  for (const Finding& finding : diagnosis.findings)
    text += std::string(severity_name(finding.severity)) + ": " + finding.check + ": " + finding.text + "\n";
  return text;
}

/// Applies `change` to every sample's three or fewer channels from `offset` on: (frame, pixel x, y, values).
using Change = std::function<void(const Frame&, int, int, float*)>;
inline void change_samples(Frame& frame, int offset, int channels, const Change& change) {
  for (int s = 0; s < frame.spp; ++s)
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x) {
        const auto p = static_cast<size_t>(y * frame.width + x);
        float values[3] = {0, 0, 0};
        for (int c = 0; c < channels; ++c) values[c] = frame.plane(s, offset + c)[p];
        change(frame, x, y, values);
        for (int c = 0; c < channels; ++c) frame.plane(s, offset + c)[p] = values[c];
      }
}

/// Three numbers behind `key` in the text of ldCamera.
inline std::array<float, 3> camera_axis(const Frame& frame, const std::string& key) {
  std::array<float, 3> axis{};
  const size_t at = frame.info.camera.find(key + " ");
  EXPECT_NE(at, std::string::npos) << frame.info.camera;
  EXPECT_EQ(
      std::sscanf(frame.info.camera.c_str() + at + key.size(), "%f %f %f", &axis[0], &axis[1], &axis[2]), 3);
  return axis;
}

inline void to_world_space(Picture& picture) {
  const auto right = camera_axis(picture.frame, "right"), up = camera_axis(picture.frame, "up");
  const std::array<float, 3> back = {right[1] * up[2] - right[2] * up[1], right[2] * up[0] - right[0] * up[2],
                                     right[0] * up[1] - right[1] * up[0]};
  change_samples(picture.frame, kNormalOffset, 3, [&](const Frame&, int, int, float* n) {
    const float view[3] = {n[0], n[1], n[2]};
    for (size_t c = 0; c < 3; ++c) n[c] = view[0] * right[c] + view[1] * up[c] + view[2] * back[c];
  });
}

inline void to_ray_distance(Picture& picture) {
  const double focal = 0.5 * kSize / std::tan(0.5 * *field_of_view(picture.frame.info.camera));
  change_samples(picture.frame, kDepthOffset, 1, [&](const Frame&, int x, int y, float* depth) {
    const double dx = (x + 0.5 - 0.5 * kSize) / focal, dy = (y + 0.5 - 0.5 * kSize) / focal;
    if (*depth < kEscapedDepth) *depth *= static_cast<float>(std::sqrt(1 + dx * dx + dy * dy));
  });
}

/// Each sample's picture with a tent of 3 x 3 pixels.
inline void blur_samples(Picture& picture) {
  Frame& frame = picture.frame;
  for (int s = 0; s < frame.spp; ++s)
    for (int c = 0; c < 3; ++c) {
      const std::vector<float> before(frame.plane(s, c), frame.plane(s, c) + frame.plane_size());
      for (int y = 0; y < kSize; ++y)
        for (int x = 0; x < kSize; ++x) {
          float sum = 0, weights = 0;
          for (int j = std::max(y - 1, 0); j <= std::min(y + 1, kSize - 1); ++j)
            for (int i = std::max(x - 1, 0); i <= std::min(x + 1, kSize - 1); ++i) {
              const float weight = (i == x ? 2.0F : 1.0F) * (j == y ? 2.0F : 1.0F);
              sum += weight * before[static_cast<size_t>(j * kSize + i)];
              weights += weight;
            }
          frame.plane(s, c)[static_cast<size_t>(y * kSize + x)] = sum / weights;
        }
    }
}

/// Every guide of a pixel the mean of its samples'.
inline void average_guides(Picture& picture) {
  Frame& frame = picture.frame;
  for (int c = 3; c < channel_count(frame.features); ++c)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      float mean = 0;
      for (int s = 0; s < frame.spp; ++s) mean += frame.plane(s, c)[p] / static_cast<float>(frame.spp);
      for (int s = 0; s < frame.spp; ++s) frame.plane(s, c)[p] = mean;
    }
}

/// Sets `value` in every `step`-th sample of channel `channel`.
inline void sprinkle(Picture& picture, int channel, size_t step, float value) {
  size_t count = 0;
  for (int s = 0; s < picture.frame.spp; ++s)
    for (size_t p = 0; p < picture.frame.plane_size(); ++p)
      if (count++ % step == 0) picture.frame.plane(s, channel)[p] = value;
}

}  // namespace ld
