// The little of HDF5 that the layout needs, with complaints in one line. The library itself, and some thirty
// that it loads, are in a module (core/module.h), hdf5_module.cpp, so that only who has such files waits for
// them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace ld {

/// A data set of floats, read and written one frame (the first dimension) at a time.
struct Hdf5Data {
  virtual ~Hdf5Data() = default;

  std::string where;  // "file.h5: data set 'color'"
  std::vector<uint64_t> dimensions;
  size_t frame_values() const {  // values that a frame has
    size_t values = 1;
    for (size_t i = 1; i < dimensions.size(); ++i) values *= dimensions[i];
    return values;
  }

  /// Throws Error when HDF5 cannot.
  virtual void read_frame(uint64_t frame, std::vector<float>& values) const = 0;
  virtual void write_frame(uint64_t frame, const std::vector<float>& values) const = 0;
};

class Hdf5File {
 public:
  /// Opens for reading. Throws Error: missing, not HDF5, no module.
  static std::unique_ptr<Hdf5File> open(const std::filesystem::path& path);
  /// Makes a new file.
  static std::unique_ptr<Hdf5File> create(const std::filesystem::path& path);

  virtual ~Hdf5File() = default;

  /// Throws Error when not all of it reaches the file.
  virtual void flush() const = 0;

  virtual bool has(const std::string& name) const = 0;

  /// Throws Error: no such data set, not of floats, other than `rank` dimensions, empty, absurd or larger
  /// than the file's bytes can unpack to.
  virtual std::unique_ptr<Hdf5Data> data(const std::string& name, size_t rank) const = 0;

  /// A data set of half floats (or, where `full`, floats), compressed, in pieces of one sample.
  virtual std::unique_ptr<Hdf5Data> make(const std::string& name, const std::vector<uint64_t>& dimensions,
                                         bool full = false) const = 0;
};

/// What the module gives.
class Hdf5Library {
 public:
  virtual ~Hdf5Library() = default;
  virtual std::unique_ptr<Hdf5File> open(const std::filesystem::path& path) const = 0;
  virtual std::unique_ptr<Hdf5File> create(const std::filesystem::path& path) const = 0;
};

/// Loads the module at the first call. Throws Error where it is missing: the program was built without HDF5.
const Hdf5Library& hdf5_library();

}  // namespace ld
