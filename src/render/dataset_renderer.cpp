#include "render/dataset_renderer.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <vector>

#include "core/checksum.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/signals.h"
#include "core/threads.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "render/image_renderer.h"

namespace ld {
namespace {

Manifest manifest_of(const Recipe& recipe) {
  Manifest manifest;
  manifest.recipe = config_to_yaml(recipe);
  manifest.seed = recipe.seed;
  return manifest;
}

/// Frames of [begin, end) that the folder does not hold complete.
std::vector<int64_t> missing_frames(const Recipe& recipe, const std::filesystem::path& folder, int64_t begin,
                                    int64_t end) {
  add_to_manifest(folder, manifest_of(recipe));  // another recipe's folder is an error now, not after an hour
  std::map<std::string, ManifestFrame> held;
  for (const ManifestFrame& frame : read_manifest(folder).frames) held[frame.name] = frame;
  std::vector<int64_t> missing;
  for (int64_t frame = begin; frame < end; ++frame) {
    const auto entry = held.find(frame_name(frame));
    if (entry != held.end()) {
      try {
        verify_frame(folder, entry->second);
        continue;
      } catch (const Error& error) {
        spdlog::warn("{}; rendering it again", error.what());
      }
    }
    missing.push_back(frame);
  }
  return missing;
}

/// Counts paths from all threads into the progress bar, in thousands.
class PathCounter {
 public:
  PathCounter(int64_t total, int64_t frames) : progress_("thousand paths", total / 1000), frames_(frames) {}

  void start_frame() { ++started_; }
  void add(int64_t paths) {
    const int64_t before = paths_.fetch_add(paths), thousands = (before + paths) / 1000 - before / 1000;
    if (thousands > 0) progress_.advance(thousands, fmt::format("frame {} of {}", started_.load(), frames_));
  }
  int64_t paths() const { return paths_; }

 private:
  Progress progress_;
  std::atomic<int64_t> paths_{0}, started_{0};
  int64_t frames_;
};

class DatasetRenderer {
 public:
  DatasetRenderer(const Recipe& recipe, std::filesystem::path folder, PathCounter& counter)
      : recipe_(recipe), folder_(std::move(folder)), counter_(counter) {}

  void render_frame(int64_t frame, int threads) {
    if (stop_requested()) return;
    counter_.start_frame();
    RenderSettings settings;
    settings.seed = recipe_.seed;
    settings.frame = static_cast<uint32_t>(frame);
    settings.threads = threads;
    settings.path.max_bounces = static_cast<int>(recipe_.max_bounces);
    settings.stop = stop_requested;
    settings.progress = [this](int64_t paths) { counter_.add(paths); };

    const auto scene =
        prepare_random_scene(recipe_.scenes, recipe_.seed, settings.frame, recipe_.width(), recipe_.height());
    settings.spp = static_cast<int>(recipe_.spp);
    std::optional<Frame> samples = render_samples(*scene, settings);
    if (!samples) return;
    settings.spp = static_cast<int>(recipe_.reference_spp_of(frame));
    const std::optional<Image> reference = render_reference(*scene, settings);
    if (!reference) return;
    write(frame, *samples, *reference);
  }

  int64_t finished() const { return finished_; }
  int64_t clamped() const { return clamped_; }

 private:
  void write(int64_t frame, Frame& samples, const Image& reference) {
    ManifestFrame entry;
    entry.name = frame_name(frame);
    entry.split = recipe_.split(frame);
    entry.index = frame;
    samples.info.generator = "ld_render " LD_VERSION;
    clamped_ += write_frame(frame_path(folder_, entry.name), samples);
    write_image(reference_path(folder_, entry.name), reference);
    entry.checksum = file_checksum(frame_path(folder_, entry.name));
    entry.reference_checksum = file_checksum(reference_path(folder_, entry.name));
    // The entry comes last: a frame without one is rendered again.
    Manifest addition = manifest_of(recipe_);
    addition.frames.push_back(entry);
    const std::lock_guard<std::mutex> lock(manifest_mutex_);
    add_to_manifest(folder_, addition);
    ++finished_;
  }

  const Recipe& recipe_;
  std::filesystem::path folder_;
  PathCounter& counter_;
  std::mutex manifest_mutex_;
  std::atomic<int64_t> finished_{0}, clamped_{0};
};

}  // namespace

RenderReport render_dataset(const Recipe& recipe, const std::filesystem::path& folder, int64_t begin,
                            int64_t end, int threads) {
  const std::vector<int64_t> frames = missing_frames(recipe, folder, begin, end);
  const auto count = static_cast<int64_t>(frames.size());
  int64_t total = 0;
  for (const int64_t frame : frames) total += recipe.paths(frame);
  const auto start = std::chrono::steady_clock::now();
  PathCounter counter(total, count);
  DatasetRenderer renderer(recipe, folder, counter);

  // A frame a thread while there are plenty: building and writing, which take one thread, then overlap with
  // tracing. The last frames are shared by all threads, so that none waits for another's long frame.
  const int64_t shared = std::min(count, int64_t{2} * threads);
  parallel_for(count - shared, threads,
               [&](int64_t i) { renderer.render_frame(frames[static_cast<size_t>(i)], 1); });
  for (int64_t i = count - shared; i < count; ++i)
    renderer.render_frame(frames[static_cast<size_t>(i)], threads);

  RenderReport report;
  report.rendered = renderer.finished();
  report.present = end - begin - count;
  report.left = count - report.rendered;
  report.paths = counter.paths();
  report.clamped = renderer.clamped();
  report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return report;
}

}  // namespace ld
