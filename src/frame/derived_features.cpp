#include "frame/derived_features.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "frame/frame_file.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

void add_half_radiance(Frame& frame, const fs::path& path) {
  const fs::path companion = half_companion(path);
  Faults ignored;  // of a picture whose pixels are masked one by one below
  const Frame half = read_frame(companion, {}, ignored);
  const int width = (frame.width + 1) / 2, height = (frame.height + 1) / 2;
  if (half.width != width || half.height != height || half.spp < frame.spp)
    fail(
        "{}: {} x {} pixels with {} samples; expected {} x {} with {} or more, half of {} x {} rounded up; "
        "render both again",
        companion.string(), half.width, half.height, half.spp, width, height, frame.spp, frame.width,
        frame.height);
  const Image mean = mean_radiance(half);
  for (int s = 0; s < frame.spp; ++s) {
    const uint8_t *drawn = half.valid_plane(s), *valid = frame.valid_plane(s);
    for (int c = 0; c < 3; ++c) {
      const float *own = half.plane(s, c), *otherwise = mean.plane(c);
      float* to = frame.plane(s, kHalfRadianceOffset + c);
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        const size_t x = p % size_t(frame.width) / 2, y = p / size_t(frame.width) / 2,
                     from = y * size_t(width) + x;
        to[p] = valid[p] == 0 ? 0.0F : drawn[from] != 0 ? own[from] : otherwise[from];
      }
    }
  }
}

void add_position(Frame& frame) {
  const CameraPlace camera = camera_place(*frame.info.world_to_camera);
  // How far the picture goes to each side at depth 1, from where the points beside the axis are seen.
  const auto seen = [&](const std::array<double, 3>& aside) {
    std::array<double, 3> point{};
    for (size_t i = 0; i < 3; ++i) point[i] = camera.position[i] - camera.back[i] + aside[i];
    return project_to_ndc(*frame.info.world_to_ndc, point);
  };
  const std::array<double, 2> middle = seen({0, 0, 0}), right = seen(camera.right), up = seen(camera.up);
  const double per_x = 1 / (right[0] - middle[0]), per_y = 1 / (up[1] - middle[1]);
  const Windows& windows = frame.info.windows;
  const bool displayed = windows.has_display();
  const double left = displayed ? windows.display_left - windows.x : 0,
               top = displayed ? windows.display_top - windows.y : 0,
               across = displayed ? windows.display_right - windows.display_left + 1.0 : frame.width,
               down = displayed ? windows.display_bottom - windows.display_top + 1.0 : frame.height;
  for (int s = 0; s < frame.spp; ++s) {
    const float* depth = frame.plane(s, kDepthOffset);
    const uint8_t* valid = frame.valid_plane(s);
    for (int y = 0; y < frame.height; ++y)
      for (int x = 0; x < frame.width; ++x) {
        const size_t p = size_t(y) * size_t(frame.width) + size_t(x);
        const double d = valid[p] != 0 ? double(depth[p]) : 0;
        const double place[3] = {d * ((x + 0.5 - left) / across - middle[0]) * per_x,
                                 d * ((y + 0.5 - top) / down - middle[1]) * per_y, -d};
        for (int c = 0; c < 3; ++c)
          frame.plane(s, kPositionOffset + c)[p] =
              std::clamp(static_cast<float>(place[c]), -kHalfMax, kHalfMax);
      }
  }
}

}  // namespace

fs::path half_companion(const fs::path& frame) {
  fs::path path = frame;
  return path.replace_extension(".half.exr");
}

std::vector<std::string> derivable_features(const fs::path& frame, const std::vector<std::string>& held,
                                            const FrameInfo& info) {
  const auto holds = [&](const char* name) {
    return std::find(held.begin(), held.end(), name) != held.end();
  };
  std::vector<std::string> names;
  std::error_code ignored;  // what cannot be looked at counts as missing
  if (!holds("half_radiance") && fs::is_regular_file(half_companion(frame), ignored))
    names.emplace_back("half_radiance");
  if (!holds("position") && holds("depth") && info.world_to_camera && info.world_to_ndc)
    names.emplace_back("position");
  return names;
}

void add_derived(Frame& frame, const std::string& feature, const fs::path& path) {
  if (feature == "half_radiance")
    add_half_radiance(frame, path);
  else
    add_position(frame);
  frame.features.push_back(feature);
}

}  // namespace ld
