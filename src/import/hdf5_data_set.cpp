#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <map>

#include "core/error.h"
#include "core/file_io.h"
#include "frame/exr_check.h"
#include "frame/frame_file.h"
#include "frame/frame_pair.h"
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

void check_like(const FrameHeader& header, const FrameHeader& first, const std::string& name) {
  if (header.width != first.width || header.height != first.height || header.spp != first.spp)
    fail(
        "{}: {} x {} pixels with {} samples, but the first frame has {} x {} with {}; one HDF5 file holds "
        "one size",
        name, header.width, header.height, header.spp, first.width, first.height, first.spp);
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
  if (own) depth = Hdf5Depth::ratio;

  for (hsize_t i = 0; i < size[0]; ++i) {
    Frame frame(static_cast<int>(size[4]), static_cast<int>(size[3]), static_cast<int>(size[1]));
    frame.features.clear();
    for (const OpenGroup& group : groups) {
      for (const std::string& feature : features_of(*group.layout)) frame.features.push_back(feature);
      group.data.read_frame(i, values);
      for_each_plane(frame, *group.layout, [&](float* plane, size_t offset) {
        std::copy_n(values.data() + offset, frame.plane_size(), plane);
      });
    }
    const Faults faults = sanitise(frame);
    report.faulty_samples += faults.not_finite;
    frame_from_hdf5_units(frame, depth, scales[i]);
    frame.info.generator = "HDF5 file " + samples.filename().string();
    frame.info.frame = static_cast<int64_t>(i);
    frame.info.depth_scale = depth == Hdf5Depth::ratio ? scales[i] : median_depth(frame);
    ImportedPicture picture{Image(frame.width, frame.height, 3), {}};
    reference.read_frame(i, picture.image.pixels);
    add_to_data_set({folder, fmt::format("{}_{:06}", name, i), split}, frame, picture);
    ++report.frames;
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
    const fs::path path = frame_path(folder, entry.name);
    const FrameHeader header = read_frame_header(path);
    check_like(header, first, path.string());
    for (const std::string& feature : header.features) ++held[feature];
  }
  const hsize_t frames = entries.size(), spp = static_cast<hsize_t>(first.spp);
  const hsize_t height = static_cast<hsize_t>(first.height), width = static_cast<hsize_t>(first.width);

  const auto write = [&](const fs::path& samples_path, const fs::path& references_path) {
    const Hdf5File file = Hdf5File::create(samples_path), reference_file = Hdf5File::create(references_path);
    std::vector<OpenGroup> groups;
    std::vector<std::string> needed;
    for (const Hdf5Group& layout : hdf5_layout()) {
      const std::vector<std::string> features = features_of(layout);
      if (!std::all_of(features.begin(), features.end(),
                       [&](const auto& f) { return held[f] == entries.size(); })) {
        report.left_out.emplace_back(layout.name);
        continue;
      }
      needed.insert(needed.end(), features.begin(), features.end());
      groups.push_back({&layout, file.make(layout.name, {frames, spp, static_cast<hsize_t>(layout.channels),
                                                         height, width})});
    }
    const Hdf5Data scales = file.make("depth_scale", {frames}, true);
    const Hdf5Data reference = reference_file.make("color", {frames, 3, height, width});
    std::vector<float> values;
    for (hsize_t i = 0; i < frames; ++i) {
      FramePair pair = read_frame_pair(folder, entries[i], needed);
      Frame& frame = pair.frame;
      report.faulty_samples += pair.faults.not_finite;
      scales.write_frame(i, {frame.info.depth_scale});
      frame_to_hdf5_units(frame);
      for (int s = 0; s < frame.spp; ++s)  // samples that were not drawn
        for (int c = 0; c < 3; ++c)
          for (size_t p = 0; p < frame.plane_size(); ++p)
            if (frame.valid_plane(s)[p] == 0) frame.plane(s, c)[p] = std::numeric_limits<float>::quiet_NaN();
      for (const OpenGroup& group : groups) {
        values.resize(group.data.frame_values());
        for_each_plane(frame, *group.layout, [&](const float* plane, size_t offset) {
          std::copy_n(plane, frame.plane_size(), values.data() + offset);
        });
        group.data.write_frame(i, values);
      }
      reference.write_frame(i, pair.reference.image.pixels);
      ++report.frames;
    }
    file.flush();
    reference_file.flush();
  };
  write_atomically(samples, [&](const fs::path& samples_path) {
    write_atomically(references,
                     [&](const fs::path& references_path) { write(samples_path, references_path); });
  });
  if (held["flow"] > 0) report.left_out.emplace_back("flow");
  return report;
}

}  // namespace ld
