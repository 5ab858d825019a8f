#include "render/recipe/contact_sheet.h"

#include <algorithm>
#include <mutex>
#include <vector>

#include "core/error.h"
#include "core/progress.h"
#include "core/threads.h"
#include "frame/frame_file.h"
#include "render/trace/image_renderer.h"

namespace ld {
namespace {

constexpr int kLargest = 128, kGap = 2;  // pixels

/// The scene as a smaller picture shows it.
std::unique_ptr<PreparedScene> resized(std::unique_ptr<PreparedScene> scene, int width, int height) {
  const Camera& camera = scene->scene().camera;
  if (camera.width == width && camera.height == height) return scene;
  Scene smaller = scene->scene();
  smaller.camera.width = width;
  smaller.camera.height = height;
  return std::make_unique<PreparedScene>(std::move(smaller));
}

void paste(Image& sheet, const Image& picture, int x, int y) {
  for (int c = 0; c < 3; ++c)
    for (int j = 0; j < picture.height; ++j)
      for (int i = 0; i < picture.width; ++i)
        sheet.plane(
            c)[static_cast<size_t>(y + j) * static_cast<size_t>(sheet.width) + static_cast<size_t>(x + i)] =
            picture.plane(
                c)[static_cast<size_t>(j) * static_cast<size_t>(picture.width) + static_cast<size_t>(i)];
}

}  // namespace

SheetReport render_contact_sheet(const Recipe& recipe, int64_t begin, int64_t end, int columns, int spp,
                                 const std::filesystem::path& path, int threads) {
  if (recipe.scene_file.used())
    fail_usage("a contact sheet shows random scenes; the recipe has a scene_file");
  const double shrink = std::min(
      1.0, static_cast<double>(kLargest) / static_cast<double>(std::max(recipe.width(), recipe.height())));
  const int width = std::max(1, static_cast<int>(recipe.width() * shrink));
  const int height = std::max(1, static_cast<int>(recipe.height() * shrink));
  const int count = static_cast<int>(end - begin), rows = (count + columns - 1) / columns;
  const int used = std::min(columns, count);
  Image sheet(used * (width + kGap) - kGap, rows * (height + kGap) - kGap, 3);
  SheetReport report;
  report.scenes = count;
  report.drafts = count;
  std::mutex mutex;
  Progress progress("scenes", count);
  parallel_for(count, threads, [&](int64_t i) {
    const auto frame = static_cast<uint32_t>(begin + i);
    std::vector<DraftFault> rejected;
    auto drafted =
        prepare_random_scene(recipe.scenes, recipe.seed, frame, recipe.width(), recipe.height(), &rejected);
    const auto scene = resized(std::move(drafted), width, height);
    RenderSettings settings;
    settings.seed = recipe.seed;
    settings.frame = frame;
    settings.spp = spp;
    settings.path = recipe.path_settings();
    const Image picture = *render_reference(*scene, settings);
    const int place = static_cast<int>(i);
    const std::lock_guard<std::mutex> lock(mutex);
    paste(sheet, picture, place % columns * (width + kGap), place / columns * (height + kGap));
    report.drafts += static_cast<int64_t>(rejected.size());
    for (const DraftFault fault : rejected) ++report.rejected[fault];
    progress.advance(1, "");
  });
  write_image(path, sheet);
  return report;
}

}  // namespace ld
