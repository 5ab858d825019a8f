#include "render/image_renderer.h"

#include <algorithm>
#include <atomic>

#include "core/threads.h"

namespace ld {
namespace {

// Small enough that two threads finish a picture together, large enough that handing out costs nothing.
constexpr int kTile = 8;

/// Calls shade(x, y, p) for every pixel p = y width + x, tile by tile; false when stopped.
template <class Shade>
bool for_each_pixel(const Camera& camera, const RenderSettings& settings, const Shade& shade) {
  const int tiles_x = (camera.width + kTile - 1) / kTile, tiles_y = (camera.height + kTile - 1) / kTile;
  std::atomic<bool> stopped{false};
  parallel_for(int64_t{tiles_x} * tiles_y, settings.threads, [&](int64_t tile) {
    const int x0 = static_cast<int>(tile % tiles_x) * kTile, y0 = static_cast<int>(tile / tiles_x) * kTile;
    const int x1 = std::min(x0 + kTile, camera.width), y1 = std::min(y0 + kTile, camera.height);
    for (int y = y0; y < y1; ++y)
      for (int x = x0; x < x1; ++x) {
        if (stopped || (settings.stop && settings.stop())) {
          stopped = true;
          return;
        }
        shade(x, y,
              static_cast<uint32_t>(y) * static_cast<uint32_t>(camera.width) + static_cast<uint32_t>(x));
      }
    if (settings.progress) settings.progress(int64_t{x1 - x0} * (y1 - y0) * settings.spp);
  });
  return !stopped;
}

SampleNumbers input_numbers(const RenderSettings& settings, uint32_t pixel, uint32_t sample) {
  if (!settings.low_discrepancy)
    return SampleNumbers(
        RandomStream(settings.seed, RandomPurpose::input_samples, settings.frame, pixel, sample));
  return {RandomStream(settings.seed, RandomPurpose::input_samples, settings.frame, pixel).bits(), sample};
}

}  // namespace

std::optional<Frame> render_samples(const PreparedScene& scene, const RenderSettings& settings) {
  const Camera& camera = scene.scene().camera;
  Frame frame(camera.width, camera.height, settings.spp);
  const bool complete = for_each_pixel(camera, settings, [&](int x, int y, uint32_t pixel) {
    for (int s = 0; s < settings.spp; ++s) {
      SampleNumbers numbers = input_numbers(settings, pixel, static_cast<uint32_t>(s));
      const CameraSample where = draw_camera_sample(camera, x, y, numbers);
      const auto values = trace_sample(scene, where, numbers, settings.path);
      for (int c = 0; c < kSampleChannels; ++c) frame.plane(s, c)[pixel] = values[static_cast<size_t>(c)];
    }
  });
  if (!complete) return std::nullopt;
  frame.info.seed = settings.seed;
  frame.info.frame = settings.frame;
  frame.info.scene = scene.scene().name;
  frame.info.camera = camera.describe();
  frame.info.depth_scale = median_depth(frame);
  return frame;
}

std::optional<Image> render_reference(const PreparedScene& scene, const RenderSettings& settings) {
  const Camera& camera = scene.scene().camera;
  Image image(camera.width, camera.height, 3);
  const bool complete = for_each_pixel(camera, settings, [&](int x, int y, uint32_t pixel) {
    const uint32_t pixel_seed =
        RandomStream(settings.seed, RandomPurpose::reference, settings.frame, pixel).bits();
    double sum[3] = {0, 0, 0};
    for (int s = 0; s < settings.spp; ++s) {
      SampleNumbers numbers(pixel_seed, static_cast<uint32_t>(s));
      const CameraSample where = draw_camera_sample(camera, x, y, numbers);
      const Vec3 radiance = trace_path(scene, camera.ray_at(where), where.time, numbers, settings.path);
      for (int c = 0; c < 3; ++c) sum[c] += radiance[c];
    }
    for (int c = 0; c < 3; ++c) image.plane(c)[pixel] = static_cast<float>(sum[c] / settings.spp);
  });
  if (!complete) return std::nullopt;
  return image;
}

}  // namespace ld
