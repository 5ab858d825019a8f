// The little of HDF5's C interface that the layout needs, with handles that close themselves and complaints
// in one line.
#pragma once

#include <hdf5.h>

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace ld {

/// An open HDF5 object.
class Hdf5Handle {
 public:
  using Close = herr_t (*)(hid_t);
  Hdf5Handle() = default;
  Hdf5Handle(hid_t id, Close close) : id_(id), close_(close) {}
  ~Hdf5Handle() {
    if (id_ >= 0 && close_ != nullptr) close_(id_);
  }
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(other.id_), close_(other.close_) { other.id_ = -1; }
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  hid_t get() const { return id_; }
  bool ok() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
  Close close_ = nullptr;
};

/// A data set of floats, read and written one frame (the first dimension) at a time.
struct Hdf5Data {
  Hdf5Handle handle;
  std::string where;         // "file.h5: data set 'color'"
  bool half_floats = false;  // of IEEE binary16, which frame/half_float.h converts
  std::vector<hsize_t> dimensions;
  size_t frame_values() const;  // values that a frame has

  /// Throws Error when HDF5 cannot.
  void read_frame(hsize_t frame, std::vector<float>& values) const;
  void write_frame(hsize_t frame, const std::vector<float>& values) const;
};

class Hdf5File {
 public:
  /// Opens for reading. Throws Error: missing, not HDF5.
  static Hdf5File open(const std::filesystem::path& path);
  /// Makes a new file.
  static Hdf5File create(const std::filesystem::path& path);

  /// Throws Error when not all of it reaches the file.
  void flush() const;

  bool has(const std::string& name) const;

  /// Throws Error: no such data set, not of floats, other than `rank` dimensions, empty, absurd or larger
  /// than the file's bytes can unpack to.
  Hdf5Data data(const std::string& name, size_t rank) const;

  /// A data set of half floats (or, where `full`, floats), compressed, in pieces of one sample.
  Hdf5Data make(const std::string& name, const std::vector<hsize_t>& dimensions, bool full = false) const;

 private:
  std::string path_;
  Hdf5Handle file_;
};

}  // namespace ld
