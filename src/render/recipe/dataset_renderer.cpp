#include "render/recipe/dataset_renderer.h"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <map>
#include <mutex>
#include <vector>

#include "core/checksum.h"
#include "core/error.h"
#include "core/file_io.h"
#include "core/progress.h"
#include "core/signals.h"
#include "core/threads.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "metrics/floor.h"
#include "render/recipe/scene_source.h"
#include "render/trace/image_renderer.h"

namespace ld {
namespace {

/// The recipe's text as `folder` has it where it means the same: one that was begun before recipes had all of
/// today's keys can be finished, the keys that it lacks having their defaults.
std::string recipe_text(const Recipe& recipe, const std::filesystem::path& folder) {
  std::string text = config_to_yaml(recipe);
  if (!std::filesystem::exists(folder / "manifest.json")) return text;
  std::string held = read_manifest(folder).recipe;
  try {
    const ConfigNode tree = parse_config(held, "manifest.json");
    if (config_to_yaml(config_from_tree<Recipe>(tree)) == text) return held;
  } catch (const UsageError&) {  // no recipe of ours: another one, as add_to_manifest says
  }
  return text;
}

Manifest manifest_of(const Recipe& recipe, const std::filesystem::path& folder) {
  Manifest manifest;
  manifest.recipe = recipe_text(recipe, folder);
  manifest.seed = recipe.seed;
  return manifest;
}

bool is_whole(const Recipe& recipe, const std::filesystem::path& folder,
              const std::map<std::string, ManifestFrame>& held, int64_t frame) {
  for (int64_t instance = 0; instance < recipe.sequence.noise_instances; ++instance) {
    const std::string name = frame_name(frame, instance);
    const auto entry = held.find(name);
    if (entry == held.end()) return false;
    try {
      verify_frame(folder, entry->second);
    } catch (const Error& error) {
      spdlog::warn("{}; rendering it again", error.what());
      return false;
    }
    if (recipe.half_radiance && !std::filesystem::exists(half_path(folder, name))) return false;
  }
  return true;
}

/// Frames of [begin, end) that the folder does not hold complete.
std::vector<int64_t> missing_frames(const Recipe& recipe, const std::filesystem::path& folder,
                                    const Manifest& manifest, int64_t begin, int64_t end) {
  add_to_manifest(folder, manifest);  // another recipe's folder is an error now, not after an hour
  std::map<std::string, ManifestFrame> held;
  for (const ManifestFrame& frame : read_manifest(folder).frames) held[frame.name] = frame;
  std::vector<int64_t> missing;
  for (int64_t frame = begin; frame < end; ++frame)
    if (!is_whole(recipe, folder, held, frame)) missing.push_back(frame);
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
  /// `manifest`: of the recipe, without frames.
  DatasetRenderer(const Recipe& recipe, const SceneSource& source, std::filesystem::path folder,
                  Manifest manifest, PathCounter& counter)
      : recipe_(recipe),
        source_(source),
        folder_(std::move(folder)),
        manifest_(std::move(manifest)),
        counter_(counter) {}

  void render_frame(int64_t frame, int threads) {
    if (stop_requested()) return;
    counter_.start_frame();
    RenderSettings settings;
    settings.seed = recipe_.seed;
    settings.frame = static_cast<uint32_t>(frame);
    settings.threads = threads;
    settings.path = recipe_.path_settings();
    settings.reference_parts = static_cast<int>(recipe_.reference_parts);
    settings.robust_reference = recipe_.reference_estimator == "robust";
    settings.low_discrepancy = recipe_.sampling == "low_discrepancy";
    settings.stop = stop_requested;
    settings.progress = [this](int64_t paths) { counter_.add(paths); };

    const auto scene = source_.prepare(frame);
    settings.spp = static_cast<int>(recipe_.spp);
    settings.filter_guides = recipe_.filter_guides;
    std::vector<Frame> samples;  // every instance, each followed by its halved companion if there is one
    for (int64_t instance = 0; instance < recipe_.sequence.noise_instances; ++instance) {
      if (!add_samples(*scene, settings, frame, 2 * instance, samples)) return;
      if (recipe_.half_radiance && !add_halved(*scene, settings, frame, 2 * instance + 1, samples)) return;
    }
    settings.spp = static_cast<int>(recipe_.reference_spp_of(frame));
    ReferenceHalves halves;
    const bool halved = settings.reference_parts > 1;
    const std::optional<Image> reference = render_reference(*scene, settings, halved ? &halves : nullptr);
    if (!reference) return;
    write(frame, samples, *reference,
          halved ? reference_floor(halves.first, halves.second) : ReferenceFloor{});
  }

  int64_t finished() const { return finished_; }
  int64_t clamped() const { return clamped_; }

 private:
  /// Samples of their own random numbers for each `stream` of a frame; false when stopped.
  bool add_samples(const PreparedScene& scene, RenderSettings settings, int64_t frame, int64_t stream,
                   std::vector<Frame>& samples) const {
    // Recipes have fewer than 2^27 frames (SplitNumbers), so that the upper bits are free.
    settings.frame += static_cast<uint32_t>(stream) << 27;
    std::optional<Frame> rendered = render_samples(scene, settings);
    if (!rendered) return false;
    rendered->info.frame = frame;
    rendered->info.generator = "ld_render " LD_VERSION;
    if (recipe_.sequence.used()) {
      rendered->features.emplace_back("flow");
      if (recipe_.filter_guides) rendered->features.emplace_back("flow_depth");
      rendered->info.cut = scene.scene().cut;
    }
    samples.push_back(std::move(*rendered));
    return true;
  }

  bool add_halved(PreparedScene& scene, const RenderSettings& settings, int64_t frame, int64_t stream,
                  std::vector<Frame>& samples) const {
    const Camera whole = scene.scene().camera;
    Camera halved = whole;
    halved.width = (whole.width + 1) / 2;
    halved.height = (whole.height + 1) / 2;
    scene.set_camera(halved);
    const bool complete = add_samples(scene, settings, frame, stream, samples);
    scene.set_camera(whole);
    return complete;
  }

  void write(int64_t frame, const std::vector<Frame>& samples, const Image& reference,
             const ReferenceFloor& floor) {
    // The entries come last: a frame without one is rendered again.
    Manifest addition = manifest_;
    const size_t step = recipe_.half_radiance ? 2 : 1;
    for (size_t i = 0; i < samples.size(); i += step) {
      ManifestFrame entry;
      entry.name = frame_name(frame, static_cast<int64_t>(i / step));
      entry.split = recipe_.split(frame);
      entry.index = frame;
      if (recipe_.sequence.used()) {
        entry.sequence = recipe_.sequence_of(frame);
        entry.position = recipe_.position_of(frame);
      }
      clamped_ += write_frame(frame_path(folder_, entry.name), samples[i]);
      if (recipe_.half_radiance) clamped_ += write_frame(half_path(folder_, entry.name), samples[i + 1]);
      if (i == 0)
        write_image(reference_path(folder_, entry.name), reference, {}, floor);
      else
        share_reference(frame_name(frame), entry.name);
      entry.checksum = file_checksum(frame_path(folder_, entry.name));
      entry.reference_checksum = file_checksum(reference_path(folder_, entry.name));
      addition.frames.push_back(std::move(entry));
    }
    const std::lock_guard<std::mutex> lock(manifest_mutex_);
    add_to_manifest(folder_, addition);
    ++finished_;
  }

  /// All noise instances have one reference: the same file under several names where the file system can do
  /// that.
  void share_reference(const std::string& first, const std::string& name) const {
    const std::filesystem::path from = reference_path(folder_, first), to = reference_path(folder_, name);
    write_atomically(to, [&](const std::filesystem::path& temporary) {
      std::error_code cannot_link;
      std::filesystem::remove(temporary);
      std::filesystem::create_hard_link(from, temporary, cannot_link);
      if (!cannot_link) return;
      std::error_code cannot_copy;
      std::filesystem::copy_file(from, temporary, cannot_copy);
      if (cannot_copy) fail("cannot write {}: {}", to.string(), cannot_copy.message());
    });
  }

  const Recipe& recipe_;
  const SceneSource& source_;
  std::filesystem::path folder_;
  Manifest manifest_;
  PathCounter& counter_;
  std::mutex manifest_mutex_;
  std::atomic<int64_t> finished_{0}, clamped_{0};
};

}  // namespace

std::filesystem::path half_path(const std::filesystem::path& folder, const std::string& name) {
  return folder / (name + ".half.exr");
}

RenderReport render_dataset(const Recipe& recipe, const std::filesystem::path& folder, int64_t begin,
                            int64_t end, int threads) {
  const auto source = make_scene_source(recipe);  // a scene file that cannot be read leaves no folder behind
  const Manifest manifest = manifest_of(recipe, folder);
  const std::vector<int64_t> frames = missing_frames(recipe, folder, manifest, begin, end);
  const auto count = static_cast<int64_t>(frames.size());
  int64_t total = 0;
  for (const int64_t frame : frames) total += recipe.paths(frame);
  const auto start = std::chrono::steady_clock::now();
  PathCounter counter(total, count);
  DatasetRenderer renderer(recipe, *source, folder, manifest, counter);

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
