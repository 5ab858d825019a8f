// Reading and writing the data sets of the HDF5 layout, one frame at a time.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "frame/frame_file.h"
#include "import/hdf5_file.h"
#include "import/hdf5_layout.h"

namespace ld {

/// Names of the features that a group holds.
std::vector<std::string> features_of(const Hdf5Group& group);

struct OpenGroup {
  const Hdf5Group* layout;
  std::unique_ptr<Hdf5Data> data;

  /// `values` is memory to work in. Throws Error when HDF5 cannot.
  void read(uint64_t i, Frame& frame, std::vector<float>& values) const;
  void write(uint64_t i, Frame& frame, std::vector<float>& values) const;
};

/// Throws Error for a data set of another shape.
void require_shape(const Hdf5Data& data, const std::vector<uint64_t>& expected);

/// What frames say of their cameras: the data sets world_to_camera and world_to_ndc [frames, 16] as the
/// files' attributes have them, and cut [frames], 1 after a cut.
struct Hdf5Cameras {
  std::unique_ptr<Hdf5Data> world_to_camera, world_to_ndc, cut;  // those that there are

  /// Of the matrices those that the first frame has; a cut where it has one of them.
  static Hdf5Cameras make(const Hdf5File& file, const FrameHeader& first, uint64_t frames);
  /// Throws Error for a wrong shape.
  static Hdf5Cameras open(const Hdf5File& file, uint64_t frames);
  /// Throws Error, which names the frame, where it lacks a matrix that the first one has.
  void write(uint64_t i, const FrameInfo& info, const std::string& name) const;
  void read(uint64_t i, FrameInfo& info) const;
};

}  // namespace ld
