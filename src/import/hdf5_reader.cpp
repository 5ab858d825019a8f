#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "core/error.h"
#include "core/process/child_process.h"
#include "core/progress.h"
#include "core/signals.h"
#include "frame/exr_check.h"
#include "import/frame_import.h"
#include "import/hdf5_group.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

void open_group(const Hdf5File& file, const Hdf5Group& layout, std::vector<OpenGroup>& groups) {
  groups.push_back({&layout, file.data(layout.name, 5)});
  std::vector<uint64_t> expected = groups[0].data->dimensions;
  expected[2] = static_cast<uint64_t>(layout.channels);
  require_shape(*groups.back().data, expected);
}

/// The groups of a file of samples, checked against each other; color comes first.
std::vector<OpenGroup> open_groups(const Hdf5File& file, std::vector<std::string>& left_out) {
  std::vector<OpenGroup> groups;
  for (const Hdf5Group& layout : hdf5_layout()) {
    const bool needed = groups.empty();
    if (!needed && !file.has(layout.name)) {
      left_out.emplace_back(layout.name);
      continue;
    }
    open_group(file, layout, groups);
  }
  for (const Hdf5Group& layout : hdf5_filter_layout())
    if (file.has(layout.name)) open_group(file, layout, groups);
  const std::vector<uint64_t>& size = groups[0].data->dimensions;
  if (size[1] > kMaxSamples || size[3] > kMaxImageSide || size[4] > kMaxImageSide ||
      size[1] * size[3] * size[4] > static_cast<uint64_t>(kMaxFrameSamples))
    fail(
        "{}: {} samples of {} x {} pixels; expected at most {} samples, {} pixels a side and {} samples in "
        "all",
        groups[0].data->where, size[1], size[4], size[3], kMaxSamples, kMaxImageSide, kMaxFrameSamples);
  return groups;
}

/// A group of the file that has one channel for each sample, as `color` has them.
OpenGroup open_scene_depth(const Hdf5File& file, std::vector<uint64_t> shape) {
  OpenGroup depth = {&hdf5_scene_depth(), file.data(hdf5_scene_depth().name, 5)};
  shape[2] = 1;
  require_shape(*depth.data, shape);
  return depth;
}

/// A pair of files, checked against each other, whose frames are read one by one.
class OpenPair {
 public:
  /// `depth` holds for files that this project did not write; `left_out` receives the groups that are
  /// missing.
  OpenPair(const fs::path& samples, const fs::path& references, Hdf5Depth depth,
           std::vector<std::string>& left_out)
      : file_(Hdf5File::open(samples)),
        reference_file_(Hdf5File::open(references)),
        groups_(open_groups(*file_, left_out)),
        reference_(reference_file_->data("color", 4)),
        cameras_(Hdf5Cameras::open(*file_, size(0))),
        depth_(depth),
        scales_(size(0), 1) {
    require_shape(*reference_, {size(0), 3, size(3), size(4)});
    if (!file_->has("depth_scale")) return;
    const std::unique_ptr<Hdf5Data> scales = file_->data("depth_scale", 1);
    require_shape(*scales, {size(0)});
    for (uint64_t i = 0; i < size(0); ++i) {
      scales->read_frame(i, values_);
      scales_[i] = values_[0] > 0 ? values_[0] : 1;
    }
    if (file_->has(hdf5_scene_depth().name))
      scene_depth_ = open_scene_depth(*file_, groups_[0].data->dimensions);
    depth_ = scene_depth_ ? Hdf5Depth::scene : Hdf5Depth::ratio;
  }

  uint64_t frames() const { return size(0); }

  /// In the project's units; `faults` receives what had to be masked.
  Frame frame(uint64_t i, Faults& faults) {
    std::vector<std::string> features;
    for (const OpenGroup& group : groups_)
      for (const std::string& feature : features_of(*group.layout)) features.push_back(feature);
    Frame frame(static_cast<int>(size(4)), static_cast<int>(size(3)), static_cast<int>(size(1)),
                frame_channels(features));
    frame.features = std::move(features);
    for (const OpenGroup& group : groups_) group.read(i, frame, values_);
    cameras_.read(i, frame.info);
    if (scene_depth_) scene_depth_->read(i, frame, values_);
    faults = sanitise(frame);
    frame_from_hdf5_units(frame, depth_, scales_[i]);
    frame.info.frame = static_cast<int64_t>(i);
    frame.info.depth_scale = depth_ == Hdf5Depth::linear ? median_depth(frame) : scales_[i];
    return frame;
  }

  ImportedPicture reference(uint64_t i) const {
    ImportedPicture picture{Image(static_cast<int>(size(4)), static_cast<int>(size(3)), 3), {}};
    reference_->read_frame(i, picture.image.pixels);
    return picture;
  }

 private:
  uint64_t size(size_t dimension) const { return groups_[0].data->dimensions[dimension]; }

  std::unique_ptr<Hdf5File> file_, reference_file_;
  std::vector<OpenGroup> groups_;
  std::optional<OpenGroup> scene_depth_;
  std::unique_ptr<Hdf5Data> reference_;
  Hdf5Cameras cameras_;
  Hdf5Depth depth_;
  std::vector<float> scales_, values_;
};

}  // namespace

void require_no_fault_in_hdf5(const fs::path& samples, const fs::path& references) {
  hdf5_library();  // once, rather than in the child and again here
  const bool survived = survives_in_a_child([&] {
    std::vector<std::string> left_out;
    Faults faults;
    OpenPair pair(samples, references, Hdf5Depth::ratio, left_out);
    for (uint64_t i = 0; i < pair.frames() && !stop_requested(); ++i) {
      pair.frame(i, faults);
      pair.reference(i);
    }
  });
  if (!survived)
    fail("{} or {}: the HDF5 library came to a fault while reading them; one is damaged: copy it again",
         samples.string(), references.string());
}

Hdf5Report data_set_from_hdf5(const fs::path& samples, const fs::path& references, const fs::path& folder,
                              const std::string& name, const std::string& split, Hdf5Depth depth) {
  Hdf5Report report;
  check_place({folder, name, split});
  OpenPair pair(samples, references, depth, report.left_out);
  Progress progress("frames", static_cast<int64_t>(pair.frames()));
  for (uint64_t i = 0; i < pair.frames(); ++i) {
    report.stopped = stop_requested();
    if (report.stopped) break;
    Faults faults;
    Frame frame = pair.frame(i, faults);
    report.faulty_samples += faults.not_finite;
    frame.info.generator = "HDF5 file " + samples.filename().string();
    add_to_data_set({folder, fmt::format("{}_{:06}", name, i), split}, frame, pair.reference(i));
    ++report.frames;
    progress.advance();
  }
  return report;
}

}  // namespace ld
