#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <map>
#include <optional>

#include "core/error.h"
#include "core/file_io.h"
#include "core/progress.h"
#include "core/signals.h"
#include "frame/exr_check.h"
#include "frame/frame_file.h"
#include "frame/frame_pair.h"
#include "frame/half_range.h"
#include "import/frame_import.h"
#include "import/hdf5_file.h"
#include "import/hdf5_layout.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

std::vector<std::string> features_of(const Hdf5Group& group) {
  std::vector<std::string> features;
  for (const char* feature : group.features)
    if (feature != nullptr) features.emplace_back(feature);
  return features;
}

/// Calls visit(plane of the frame, offset of that plane within a frame of the group).
template <class Visit>
void for_each_plane(Frame& frame, const Hdf5Group& group, const Visit& visit) {
  const size_t pixels = frame.plane_size();
  size_t offset = 0;
  for (int s = 0; s < frame.spp; ++s)
    for (const std::string& name : features_of(group)) {
      const Feature& feature = find_feature(name);
      for (int c = 0; c < feature.channels; ++c, offset += pixels)
        visit(frame.plane(s, feature.offset + c), offset);
    }
}

struct OpenGroup {
  const Hdf5Group* layout;
  Hdf5Data data;

  /// `values` is memory to work in.
  void read(hsize_t i, Frame& frame, std::vector<float>& values) const {
    data.read_frame(i, values);
    for_each_plane(frame, *layout, [&](float* plane, size_t offset) {
      std::copy_n(values.data() + offset, frame.plane_size(), plane);
    });
  }
  void write(hsize_t i, Frame& frame, std::vector<float>& values) const {
    values.resize(data.frame_values());
    for_each_plane(frame, *layout, [&](const float* plane, size_t offset) {
      std::copy_n(plane, frame.plane_size(), values.data() + offset);
    });
    data.write_frame(i, values);
  }
};

void require_shape(const Hdf5Data& data, const std::vector<hsize_t>& expected) {
  if (data.dimensions != expected)
    fail("{}: of the shape [{}]; expected [{}]", data.where, fmt::join(data.dimensions, ", "),
         fmt::join(expected, ", "));
}

/// The groups of a file of samples, checked against each other; color comes first.
std::vector<OpenGroup> open_groups(const Hdf5File& file, Hdf5Report& report) {
  std::vector<OpenGroup> groups;
  for (const Hdf5Group& layout : hdf5_layout()) {
    const bool needed = groups.empty();
    if (!needed && !file.has(layout.name)) {
      report.left_out.emplace_back(layout.name);
      continue;
    }
    groups.push_back({&layout, file.data(layout.name, 5)});
    std::vector<hsize_t> expected = groups[0].data.dimensions;
    expected[2] = static_cast<hsize_t>(layout.channels);
    require_shape(groups.back().data, expected);
  }
  const std::vector<hsize_t>& size = groups[0].data.dimensions;
  if (size[1] > kMaxSamples || size[3] > kMaxImageSide || size[4] > kMaxImageSide ||
      size[1] * size[3] * size[4] > static_cast<hsize_t>(kMaxFrameSamples))
    fail(
        "{}: {} samples of {} x {} pixels; expected at most {} samples, {} pixels a side and {} samples in "
        "all",
        groups[0].data.where, size[1], size[4], size[3], kMaxSamples, kMaxImageSide, kMaxFrameSamples);
  return groups;
}

/// A group of the file that has one channel for each sample, as `color` has them.
OpenGroup open_scene_depth(const Hdf5File& file, std::vector<hsize_t> shape) {
  OpenGroup depth = {&hdf5_scene_depth(), file.data(hdf5_scene_depth().name, 5)};
  shape[2] = 1;
  require_shape(depth.data, shape);
  return depth;
}

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
    report.clamped += fit_colours_in_half(frame.plane(s, 0), frame.plane(s, 1), frame.plane(s, 2), pixels);
    for (int c = 0; c < 3; ++c)
      for (size_t p = 0; p < pixels; ++p)
        if (frame.valid_plane(s)[p] == 0) frame.plane(s, c)[p] = std::numeric_limits<float>::quiet_NaN();
  }
  fit_colours_in_half(reference.plane(0), reference.plane(1), reference.plane(2), pixels);
}

void write_files(const Source& source, const fs::path& samples, const fs::path& references,
                 Hdf5Report& report) {
  const Hdf5File file = Hdf5File::create(samples), reference_file = Hdf5File::create(references);
  const hsize_t frames = source.entries.size(), spp = static_cast<hsize_t>(source.first.spp);
  const hsize_t height = static_cast<hsize_t>(source.first.height),
                width = static_cast<hsize_t>(source.first.width);
  const auto make_group = [&](const Hdf5Group& layout) -> OpenGroup {
    return {&layout,
            file.make(layout.name, {frames, spp, static_cast<hsize_t>(layout.channels), height, width})};
  };
  std::vector<OpenGroup> groups;
  std::optional<OpenGroup> scene_depth;
  for (const Hdf5Group* layout : source.layouts) {
    groups.push_back(make_group(*layout));
    if (features_of(*layout).back() == "depth") scene_depth = make_group(hdf5_scene_depth());
  }
  const Hdf5Data scales = file.make("depth_scale", {frames}, true);
  const Hdf5Data reference = reference_file.make("color", {frames, 3, height, width});
  std::vector<float> values;
  Progress progress("frames", static_cast<int64_t>(frames));
  for (hsize_t i = 0; i < frames; ++i) {
    if (stop_requested()) throw Stopped();
    FramePair pair = read_frame_pair(source.folder, source.entries[i], source.needed);
    report.faulty_samples += pair.faults.not_finite;
    scales.write_frame(i, {pair.frame.info.depth_scale});
    prepare_radiance(pair.frame, pair.reference.image, report);
    if (scene_depth) scene_depth->write(i, pair.frame, values);
    frame_to_hdf5_units(pair.frame);
    for (const OpenGroup& group : groups) group.write(i, pair.frame, values);
    reference.write_frame(i, pair.reference.image.pixels);
    ++report.frames;
    progress.advance();
  }
  file.flush();
  reference_file.flush();
}

}  // namespace

Hdf5Report data_set_from_hdf5(const fs::path& samples, const fs::path& references, const fs::path& folder,
                              const std::string& name, const std::string& split, Hdf5Depth depth) {
  Hdf5Report report;
  check_place({folder, name, split});
  const Hdf5File file = Hdf5File::open(samples), reference_file = Hdf5File::open(references);
  const std::vector<OpenGroup> groups = open_groups(file, report);
  const std::vector<hsize_t>& size = groups[0].data.dimensions;
  const Hdf5Data reference = reference_file.data("color", 4);
  require_shape(reference, {size[0], 3, size[3], size[4]});
  std::vector<float> scales(size[0], 1), values;
  const bool own = file.has("depth_scale");  // a file that this project wrote
  if (own) {
    const Hdf5Data data = file.data("depth_scale", 1);
    require_shape(data, {size[0]});
    for (hsize_t i = 0; i < size[0]; ++i) {
      data.read_frame(i, values);
      scales[i] = values[0] > 0 ? values[0] : 1;
    }
  }
  std::optional<OpenGroup> scene_depth;
  if (own && file.has(hdf5_scene_depth().name)) scene_depth = open_scene_depth(file, size);
  if (own) depth = scene_depth ? Hdf5Depth::scene : Hdf5Depth::ratio;

  Progress progress("frames", static_cast<int64_t>(size[0]));
  for (hsize_t i = 0; i < size[0]; ++i) {
    report.stopped = stop_requested();
    if (report.stopped) break;
    Frame frame(static_cast<int>(size[4]), static_cast<int>(size[3]), static_cast<int>(size[1]));
    frame.features.clear();
    for (const OpenGroup& group : groups) {
      for (const std::string& feature : features_of(*group.layout)) frame.features.push_back(feature);
      group.read(i, frame, values);
    }
    if (scene_depth) scene_depth->read(i, frame, values);
    const Faults faults = sanitise(frame);
    report.faulty_samples += faults.not_finite;
    frame_from_hdf5_units(frame, depth, scales[i]);
    frame.info.generator = "HDF5 file " + samples.filename().string();
    frame.info.frame = static_cast<int64_t>(i);
    frame.info.depth_scale = depth == Hdf5Depth::linear ? median_depth(frame) : scales[i];
    ImportedPicture picture{Image(frame.width, frame.height, 3), {}};
    reference.read_frame(i, picture.image.pixels);
    add_to_data_set({folder, fmt::format("{}_{:06}", name, i), split}, frame, picture);
    ++report.frames;
    progress.advance();
  }
  return report;
}

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
  if (held["flow"] > 0) report.left_out.emplace_back("flow");
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
