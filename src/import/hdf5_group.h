// Reading and writing the data sets of the HDF5 layout, one frame at a time.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "frame/frame.h"
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

}  // namespace ld
