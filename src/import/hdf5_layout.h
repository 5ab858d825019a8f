// The HDF5 layout of the data set published with [MH20]: one file of samples, one of references, float16,
// [frames, samples, channels, height, width] (references without samples).
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// A data set of the file and the features that its channels hold, in their order.
struct Hdf5Group {
  const char* name;
  int channels;
  std::array<const char*, 2> features;  // the second may be nullptr
  bool full = false;                    // floats, not half floats
};

/// color 3, normals_depth 4, albedo 3, specular 4 (colour, roughness), motionvecs 3 (NDC motion vector,
/// signed radius of the circle of confusion), uvt 3 (lens position, time).
const std::vector<Hdf5Group>& hdf5_layout();

/// What this project writes besides: depths as frames hold them. Half floats between 0.5 and 1 are 1/2048
/// apart, so that d / (d + s) has an error of a tenth at d = 400 s.
const Hdf5Group& hdf5_scene_depth();

/// What filters and sequences need, as frames hold it, a data set for each feature: another thing that this
/// project writes besides, where all frames have it.
const std::vector<Hdf5Group>& hdf5_filter_layout();

/// How the channel of depths is meant. `ratio`: d / (d + s), s the frame's depth scale, 1 where the ray
/// escaped (what this project writes, with s in the data set `depth_scale`); `linear`: as it stands, where
/// normals are zero the ray escaped; `scene`: as frames have them.
enum class Hdf5Depth { ratio, linear, scene };

/// From and to the units of the file, for all channels of one frame: NDC (+-1 across the picture, +y up) to
/// pixels (+y down) and depths. `features` are those that the frame holds.
void frame_from_hdf5_units(Frame& frame, Hdf5Depth depth, float depth_scale);
void frame_to_hdf5_units(Frame& frame);

struct Hdf5Report {
  int64_t frames = 0;
  std::vector<std::string> left_out;  // data sets that are missing, or features that the layout cannot hold
  int64_t faulty_samples = 0;
  int64_t clamped = 0;  // radiance channels beyond half's range, darkened with their colours (write_frame)
  bool stopped =
      false;  // by a signal (core/signals.h): the frames before are whole, a pair of files is not made
};

/// Throws Error when HDF5 faults on one of the files, as it does on some that are damaged: reads all of them
/// in a process of its own. What is wrong without a fault is left to data_set_from_hdf5().
void require_no_fault_in_hdf5(const std::filesystem::path& samples, const std::filesystem::path& references);

/// Adds all frames of a pair of files to a data set, as NAME_000000, ... Throws Error: files that are no
/// HDF5, missing data sets, wrong types or shapes, sizes beyond reason or beyond what the file can hold.
/// Throws Error where the module that reads HDF5 (hdf5_file.h) is missing.
Hdf5Report data_set_from_hdf5(const std::filesystem::path& samples, const std::filesystem::path& references,
                              const std::filesystem::path& folder, const std::string& name,
                              const std::string& split, Hdf5Depth depth);

/// Writes the frames of a split, or nothing when a signal stops it; data sets whose features some frame lacks
/// are left out. Throws Error: frames of different sizes or numbers of samples.
Hdf5Report data_set_to_hdf5(const std::filesystem::path& folder, const std::string& split,
                            const std::filesystem::path& samples, const std::filesystem::path& references);

}  // namespace ld
