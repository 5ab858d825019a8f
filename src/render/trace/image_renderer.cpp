#include "render/trace/image_renderer.h"

#include <algorithm>
#include <atomic>
#include <vector>

#include "core/threads.h"
#include "render/geometry/robust_mean.h"

namespace ld {
namespace {

// Small enough that two threads finish a picture together, large enough that handing out costs nothing.
constexpr int kTile = 8;

struct Tile {
  int x0, y0, x1, y1;
  int width() const { return x1 - x0; }
  int pixels() const { return width() * (y1 - y0); }
};

/// Calls render(tile) for all tiles; false when stopped. render returns false when it was.
template <class Render>
bool for_each_tile(const Camera& camera, const RenderSettings& settings, const Render& render) {
  const int tiles_x = (camera.width + kTile - 1) / kTile, tiles_y = (camera.height + kTile - 1) / kTile;
  std::atomic<bool> stopped{false};
  parallel_for(int64_t{tiles_x} * tiles_y, settings.threads, [&](int64_t index) {
    const int x0 = static_cast<int>(index % tiles_x) * kTile, y0 = static_cast<int>(index / tiles_x) * kTile;
    const Tile tile = {x0, y0, std::min(x0 + kTile, camera.width), std::min(y0 + kTile, camera.height)};
    if (stopped || !render(tile)) {
      stopped = true;
      return;
    }
    if (settings.progress) settings.progress(int64_t{tile.pixels()} * settings.spp);
  });
  return !stopped;
}

/// Calls shade(x, y, p) for the pixels p = y width + x of a tile; false when stopped.
template <class Shade>
bool for_each_pixel(const Tile& tile, const Camera& camera, const RenderSettings& settings,
                    const Shade& shade) {
  for (int y = tile.y0; y < tile.y1; ++y)
    for (int x = tile.x0; x < tile.x1; ++x) {
      if (settings.stop && settings.stop()) return false;
      shade(x, y, static_cast<uint32_t>(y) * static_cast<uint32_t>(camera.width) + static_cast<uint32_t>(x));
    }
  return true;
}

void add_matrices(const Camera& camera, FrameInfo& info) {
  const auto triple = [](Vec3 v) { return std::array<double, 3>{v.x, v.y, v.z}; };
  const CameraPlace place = {triple(camera.position), triple(camera.axes.x), triple(camera.axes.y),
                             triple(camera.axes.z)};
  const double half_height = std::tan(0.5 * camera.fov);
  info.world_to_camera = world_to_camera(place);
  info.world_to_ndc = world_to_ndc(place, half_height * camera.width / camera.height, half_height);
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
  Frame frame(camera.width, camera.height, settings.spp,
              settings.filter_guides ? kAllChannels : kSampleChannels);
  const auto channels = static_cast<size_t>(frame.channels);
  const bool complete = for_each_tile(camera, settings, [&](const Tile& tile) {
    // A sample has many planes, far apart in memory: they are filled a row of the tile at a time.
    const auto pixels = static_cast<size_t>(tile.pixels());
    std::vector<float> values(static_cast<size_t>(settings.spp) * channels * pixels);
    size_t done = 0;
    const bool whole = for_each_pixel(tile, camera, settings, [&](int x, int y, uint32_t pixel) {
      for (int s = 0; s < settings.spp; ++s) {
        SampleNumbers numbers = input_numbers(settings, pixel, static_cast<uint32_t>(s));
        const CameraSample where = draw_camera_sample(camera, x, y, numbers);
        const auto sample = trace_sample(scene, where, numbers, settings.path);
        float* const to = &values[static_cast<size_t>(s) * channels * pixels + done];
        for (size_t c = 0; c < channels; ++c) to[c * pixels] = sample[c];
      }
      ++done;
    });
    const auto width = static_cast<size_t>(tile.width());
    for (size_t plane = 0; whole && plane < static_cast<size_t>(settings.spp) * channels; ++plane)
      for (int y = tile.y0; y < tile.y1; ++y)
        std::copy_n(&values[plane * pixels + static_cast<size_t>(y - tile.y0) * width], width,
                    &frame.samples[plane * frame.plane_size() +
                                   static_cast<size_t>(y) * static_cast<size_t>(camera.width) +
                                   static_cast<size_t>(tile.x0)]);
    return whole;
  });
  if (!complete) return std::nullopt;
  frame.info.seed = settings.seed;
  frame.info.frame = settings.frame;
  frame.info.scene = scene.scene().name;
  frame.info.camera = camera.describe();
  frame.info.depth_scale = median_depth(frame);
  if (settings.filter_guides) {
    frame.features.insert(frame.features.end(), {"id", "direct", "indirect", "emission"});
    add_matrices(camera, frame.info);
  }
  return frame;
}

std::optional<Image> render_reference(const PreparedScene& scene, const RenderSettings& settings,
                                      ReferenceHalves* halves) {
  const Camera& camera = scene.scene().camera;
  const auto parts = static_cast<size_t>(settings.reference_parts);
  const int part_spp = settings.spp / settings.reference_parts;
  Image image(camera.width, camera.height, 3);
  if (halves != nullptr) halves->first = halves->second = image;
  /// Puts the estimate of parts [begin, end) into a pixel.
  const auto estimate = [&](const std::vector<Radiance>& means, size_t begin, size_t end, uint32_t pixel,
                            Image& to) {
    const std::vector<Radiance> chosen(means.begin() + static_cast<ptrdiff_t>(begin),
                                       means.begin() + static_cast<ptrdiff_t>(end));
    const Radiance value = settings.robust_reference ? robust_mean(chosen) : plain_mean(chosen);
    for (int c = 0; c < 3; ++c) to.plane(c)[pixel] = static_cast<float>(value[static_cast<size_t>(c)]);
  };
  const auto shade = [&](int x, int y, uint32_t pixel) {
    std::vector<Radiance> means(parts);
    for (size_t part = 0; part < parts; ++part) {
      const uint32_t part_seed = RandomStream(settings.seed, RandomPurpose::reference, settings.frame, pixel,
                                              static_cast<uint32_t>(part))
                                     .bits();
      Radiance sum = {0, 0, 0};
      for (int s = 0; s < part_spp; ++s) {
        SampleNumbers numbers(part_seed, static_cast<uint32_t>(s));
        const CameraSample where = draw_camera_sample(camera, x, y, numbers);
        const Vec3 radiance = trace_path(scene, camera.ray_at(where), where.time, numbers, settings.path);
        for (int c = 0; c < 3; ++c) sum[static_cast<size_t>(c)] += radiance[c];
      }
      for (size_t c = 0; c < 3; ++c) means[part][c] = sum[c] / part_spp;
    }
    estimate(means, 0, parts, pixel, image);
    if (halves == nullptr) return;
    estimate(means, 0, parts / 2, pixel, halves->first);
    estimate(means, parts / 2, parts, pixel, halves->second);
  };
  const bool complete = for_each_tile(
      camera, settings, [&](const Tile& tile) { return for_each_pixel(tile, camera, settings, shade); });
  if (!complete) return std::nullopt;
  return image;
}

}  // namespace ld
