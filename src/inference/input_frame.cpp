#include "inference/input_frame.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "core/error.h"
#include "core/threads.h"
#include "frame/exr_reader.h"
#include "frame/frame_file.h"
#include "import/file_views.h"
#include "import/frame_import.h"
#include "import/sample_window.h"
#include "import/source_plan.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// A frame's first part is the mean, unless somebody left that out and it is a sample.
Original original_of_frame(const fs::path& file, const Frame& frame) {
  const ExrReader exr(file);
  Original original;
  original.file = file;
  original.windows = frame.info.windows;
  original.replaced = {{0, "R"}, {0, "G"}, {0, "B"}};
  if (!frame.alpha.empty()) original.replaced.insert({0, "A"});
  for (int part = 0; part < exr.parts(); ++part)
    if (sample_number(exr.part_name(part)) >= 0) original.samples.insert(part);
  return original;
}

/// The part with the radiance of the first file. Of other samples in that file, the parts with their radiance
/// are samples.
Original original_of_render(const fs::path& file, const ImportMapping& mapping, const Frame& frame) {
  const ExrReader exr(file);
  Original original;
  original.file = file;
  original.windows = frame.info.windows;
  const std::vector<SourceSample> samples = plan_samples(exr, mapping, Wanted::picture);
  original.part = samples[0].features[0].channels[0].part;
  const FileViews views(exr, mapping.view);
  original.prefix = views.prefix();
  original.leads = views.is_hero();
  for (const SourceSample& sample : samples) {
    const int part = sample.features[0].channels[0].part;
    if (part != original.part) original.samples.insert(part);
    for (const SourceFeature& source : {sample.features[0], sample.alpha})
      for (const SourceChannel& channel : source.channels)
        original.replaced.insert({channel.part, channel.name});
  }
  return original;
}

/// The mapping without what would need a camera that is not there, but for `features`, without which nothing
/// goes; `notes` receives what that cost.
ImportMapping without_camera(const fs::path& file, const RenderInput& render,
                             const std::vector<std::string>& features, std::vector<std::string>& notes) {
  ImportMapping mapping = *render.mapping;
  const ExrReader exr(file);
  const std::optional<ViewCamera> camera =
      render.camera ? render.camera : FileViews(exr, mapping.view).camera();
  for (FeatureMapping& feature : mapping.features) {
    const bool lacks = camera ? needs_fov(feature) && !camera->fov_y : needs_camera(feature);
    if (lacks && std::count(features.begin(), features.end(), feature.feature) == 0) feature.channels.clear();
  }
  const auto found = [&](const ImportMapping& from) {
    std::map<std::string, std::string> channels;
    const std::vector<SourceSample> samples = plan_samples(exr, from, Wanted::all);
    for (const SourceFeature& source : samples[0].features)
      channels[source.mapping->feature] = source.channels[0].name;
    return channels;
  };
  const std::map<std::string, std::string> kept = found(mapping);
  for (const auto& [feature, channel] : found(*render.mapping))
    if (kept.count(feature) == 0)
      notes.push_back(fmt::format("{} left out: {} needs the camera; --camera gives it (docs/import.md)",
                                  feature, channel));
    else if (kept.at(feature) != channel)
      notes.push_back(
          fmt::format("{} from {}, because {} needs the camera; --camera gives it (docs/import.md)", feature,
                      kept.at(feature), channel));
  return mapping;
}

InputFrame import_input(const std::vector<fs::path>& files, const RenderInput& render,
                        const std::vector<std::string>& features) {
  std::vector<std::string> notes;
  const ImportMapping mapping = without_camera(files[0], render, features, notes);
  ImportedFrame imported = import_frame(files, mapping, render.camera, render.allow_identical, render.also);
  for (const std::string& feature : features)
    if (!imported.frame.holds(feature))
      fail(
          "{}: the renders hold {}, but not the feature '{}' that the model reads; {}render it, or use a "
          "model "
          "whose `features` leave '{}' out",
          files[0].string(), fmt::join(imported.frame.features, ", "), feature,
          imported.unused.empty()
              ? ""
              : fmt::format("if one of the channels that no feature took ({}) holds it, say so with "
                            "--set {}.channels=[...]; else ",
                            fmt::join(imported.unused, ", "), feature),
          feature);
  notes.insert(notes.end(), imported.notes.begin(), imported.notes.end());
  if (!imported.view_text.empty()) imported.taken.insert(imported.taken.begin(), imported.view_text);
  InputFrame input{
      std::move(imported.frame), imported.faults, std::move(notes), std::move(imported.taken), {}};
  input.original = original_of_render(files[0], *render.mapping, input.frame);
  if (!imported.repeated.empty())
    input.notes.push_back(fmt::format("{} the same in all samples: networks on samples make less of it",
                                      fmt::join(imported.repeated, ", ")));
  return input;
}

}  // namespace

InputFrame read_input(const std::vector<fs::path>& files, const RenderInput& render,
                      const std::vector<std::string>& features, int samples, int threads) {
  InputFrame input;
  if (render.mapping) {
    input = import_input(files, render, features);
    keep_first_samples(input.frame, samples, files[0]);
  } else {
    input.frame = read_frame(files[0], features, input.faults, samples,
                             threads > 0 ? threads : default_threads(), render.also);
    input.original = original_of_frame(files[0], input.frame);
  }
  require_valid_sample(input.frame, files[0].string());
  return input;
}

std::pair<int, int> input_size(const std::vector<fs::path>& files, const RenderInput& render) {
  if (render.mapping) {
    const Extent extent = extent_of_files(files, *render.mapping);
    return {extent.width, extent.height};
  }
  const FrameHeader header = read_frame_header(files[0]);
  return {header.width, header.height};
}

Image with_alpha(const Image& picture, const Image& alpha) {
  if (alpha.channels == 0) return picture;
  Image both(picture.width, picture.height, 4);
  std::copy(picture.pixels.begin(), picture.pixels.end(), both.pixels.begin());
  std::copy(alpha.pixels.begin(), alpha.pixels.end(), both.plane(3));
  return both;
}

}  // namespace ld
