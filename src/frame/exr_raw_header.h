// What an OpenEXR file's header says, read without the OpenEXR library and without trusting any of it.
// Layout: "OpenEXR File Layout" (https://openexr.com/en/latest/OpenEXRFileLayout.html).
#pragma once

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace ld {

struct ExrRawPart {
  std::string name, type;                  // empty where a single-part file has none
  int64_t width = 0, height = 0, top = 0;  // of the data window
  uint64_t pixel_bytes = 0;                // of all channels that are not subsampled
  bool has_window = false, has_channels = false, has_compression = false;
  bool subsampled = false;  // some channel
  bool tiled = false, one_level = true;
  uint64_t tile_width = 0, tile_height = 0;
  size_t compression = 0;    // OpenEXR's number
  int64_t chunk_count = -1;  // -1 where the header does not say

  /// "file.exr" or "file.exr: part 's003'", for complaints.
  std::string where(const std::string& path) const;
};

/// A file opened for reading numbers from it; what lies beyond its end is an Error.
class ExrBytes {
 public:
  /// Throws Error when the file is missing, a folder or unreadable.
  explicit ExrBytes(const std::filesystem::path& path);

  const std::string& path() const { return path_; }
  uint64_t size() const { return size_; }
  uint64_t position() { return static_cast<uint64_t>(file_.tellg()); }
  void seek(uint64_t position) { file_.seekg(static_cast<std::streamoff>(position)); }
  /// Throws Error "cut short WHERE".
  void read(void* to, size_t bytes, const char* where);
  template <class Number>
  Number number(const char* where = "within its header") {
    Number value{};  // EXR is little endian, as are the machines this project supports
    read(&value, sizeof value, where);
    return value;
  }
  [[noreturn]] void fail_short(const std::string& where) const;

 private:
  std::string path_;
  uint64_t size_ = 0;
  std::ifstream file_;
};

/// Reads the headers of all parts; `file` then stands at the tables of chunk offsets. Throws Error when it is
/// not an OpenEXR file, deep, cut short within the header, or has attributes that are not what OpenEXR
/// defines.
std::vector<ExrRawPart> read_raw_headers(ExrBytes& file, bool& multi_part);

}  // namespace ld
