#include <algorithm>
#include <limits>
#include <map>
#include <optional>

#include "core/error.h"
#include "core/file_io.h"
#include "core/progress.h"
#include "core/signals.h"
#include "frame/frame_file.h"
#include "frame/frame_pair.h"
#include "import/hdf5_group.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

void check_like(const FrameHeader& header, const FrameHeader& first, const std::string& name) {
  if (header.width != first.width || header.height != first.height || header.spp != first.spp)
    fail(
        "{}: {} x {} pixels with {} samples, but the first frame has {} x {} with {}; one HDF5 file holds "
        "one size",
        name, header.width, header.height, header.spp, first.width, first.height, first.spp);
}

/// Thrown where a signal asks for a stop, so that neither file is made.
struct Stopped {};

/// What is to be written: the frames, which are like the first, and the groups that all of them can fill.
struct Source {
  const fs::path& folder;
  const std::vector<ManifestFrame>& entries;
  const FrameHeader& first;
  const std::vector<const Hdf5Group*>& layouts;
  const std::vector<std::string>& needed;
};

/// To what half floats and readers of the files know: samples that were not drawn have no colour.
void prepare_radiance(Frame& frame, Image& reference, Hdf5Report& report) {
  const size_t pixels = frame.plane_size();
  for (int s = 0; s < frame.spp; ++s) {
    report.clamped += fit_in_half(frame, s);
    for (int c = 0; c < 3; ++c)
      for (size_t p = 0; p < pixels; ++p)
        if (frame.valid_plane(s)[p] == 0) frame.plane(s, c)[p] = std::numeric_limits<float>::quiet_NaN();
  }
  fit_colours_in_half(reference.plane(0), reference.plane(1), reference.plane(2), pixels);
}

void write_files(const Source& source, const fs::path& samples, const fs::path& references,
                 Hdf5Report& report) {
  const std::unique_ptr<Hdf5File> file = Hdf5File::create(samples),
                                  reference_file = Hdf5File::create(references);
  const uint64_t frames = source.entries.size(), spp = static_cast<uint64_t>(source.first.spp);
  const uint64_t height = static_cast<uint64_t>(source.first.height),
                 width = static_cast<uint64_t>(source.first.width);
  const auto make_group = [&](const Hdf5Group& layout) -> OpenGroup {
    return {&layout,
            file->make(layout.name, {frames, spp, static_cast<uint64_t>(layout.channels), height, width},
                       layout.full)};
  };
  std::vector<OpenGroup> groups;
  std::optional<OpenGroup> scene_depth;
  for (const Hdf5Group* layout : source.layouts) {
    groups.push_back(make_group(*layout));
    if (features_of(*layout).back() == "depth") scene_depth = make_group(hdf5_scene_depth());
  }
  const std::unique_ptr<Hdf5Data> scales = file->make("depth_scale", {frames}, true);
  const std::unique_ptr<Hdf5Data> reference = reference_file->make("color", {frames, 3, height, width});
  const Hdf5Cameras cameras = Hdf5Cameras::make(*file, source.first, frames);
  std::vector<float> values;
  Progress progress("frames", static_cast<int64_t>(frames));
  for (uint64_t i = 0; i < frames; ++i) {
    if (stop_requested()) throw Stopped();
    FramePair pair = read_frame_pair(source.folder, source.entries[i], source.needed);
    report.faulty_samples += pair.faults.not_finite;
    scales->write_frame(i, {pair.frame.info.depth_scale});
    cameras.write(i, pair.frame.info, source.entries[i].name);
    prepare_radiance(pair.frame, pair.reference.image, report);
    if (scene_depth) scene_depth->write(i, pair.frame, values);
    frame_to_hdf5_units(pair.frame);
    for (const OpenGroup& group : groups) group.write(i, pair.frame, values);
    reference->write_frame(i, pair.reference.image.pixels);
    ++report.frames;
    progress.advance();
  }
  file->flush();
  reference_file->flush();
}

}  // namespace

Hdf5Report data_set_to_hdf5(const fs::path& folder, const std::string& split, const fs::path& samples,
                            const fs::path& references) {
  Hdf5Report report;
  const std::vector<ManifestFrame> entries = frames_of_split(folder, split);
  std::map<std::string, size_t> held;
  const FrameHeader first = read_frame_header(frame_path(folder, entries[0].name));
  for (const ManifestFrame& entry : entries) {
    report.stopped = stop_requested();
    if (report.stopped) return report;
    const fs::path path = frame_path(folder, entry.name);
    const FrameHeader header = read_frame_header(path);
    check_like(header, first, path.string());
    for (const std::string& feature : header.features) ++held[feature];
  }
  std::vector<const Hdf5Group*> layouts;
  std::vector<std::string> needed;
  for (const Hdf5Group& layout : hdf5_layout()) {
    const std::vector<std::string> features = features_of(layout);
    if (!std::all_of(features.begin(), features.end(),
                     [&](const auto& f) { return held[f] == entries.size(); })) {
      report.left_out.emplace_back(layout.name);
      continue;
    }
    needed.insert(needed.end(), features.begin(), features.end());
    layouts.push_back(&layout);
  }
  for (const Hdf5Group& layout : hdf5_filter_layout()) {
    const size_t frames = held[layout.features[0]];
    if (frames == entries.size()) {
      needed.emplace_back(layout.features[0]);
      layouts.push_back(&layout);
    } else if (frames > 0) {
      report.left_out.emplace_back(layout.name);
    }
  }
  try {
    write_atomically(samples, [&](const fs::path& samples_path) {
      write_atomically(references, [&](const fs::path& references_path) {
        write_files({folder, entries, first, layouts, needed}, samples_path, references_path, report);
      });
    });
  } catch (const Stopped&) {
    report.stopped = true;
  }
  return report;
}

}  // namespace ld
