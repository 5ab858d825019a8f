// Reading planes of floats from the parts of an OpenEXR file, scan-line or tiled, half or float.
#pragma once

#include <ImfHeader.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPixelType.h>

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "frame/exr_check.h"
#include "frame/frame.h"

namespace ld {

/// A channel and where its data window's pixels go, row by row; `count` is how many there is room for.
struct ExrPlane {
  std::string channel;
  float* pixels;
  size_t count;
};

/// What to read of a part.
struct ExrPartPlanes {
  int part;
  std::vector<ExrPlane> planes;
};

/// A channel in the type that the pixels are wanted in.
struct ExrTypedPlane {
  std::string channel;
  Imf::PixelType type;
  char* pixels;
  size_t count;
};

/// Every complaint, OpenEXR's included, is an Error that names the file and, where it has one, the part.
class ExrReader {
 public:
  /// Checks the header as exr_check.h says, then opens the file.
  explicit ExrReader(const std::filesystem::path& path);

  const std::string& path() const { return path_; }
  int parts() const { return file_->parts(); }
  const Imf::Header& header(int part) const { return file_->header(part); }
  std::string part_name(int part) const;  // "" for a single-part file without a name
  int width(int part) const;
  int height(int part) const;
  bool has_channel(int part, const std::string& channel) const;
  std::string channel_list(int part) const;  // "B, G, R", for complaints

  /// Throws Error when a channel is missing, of integers, or subsampled.
  void require_channel(int part, const std::string& channel, const std::string& advice) const;

  /// Reads channels that require_channel() let pass. Throws Error where there is room for another number of
  /// pixels than the part's data window has.
  void read(int part, const std::vector<ExrPlane>& planes) const;

  /// The same of several parts, on up to `threads` threads; they call `done`, if given, with an index of
  /// `parts` and rows of that part as soon as these are complete. Each thread needs the memory of a chunk
  /// twice.
  using RowsDone = std::function<void(size_t index, int first_row, int rows)>;
  void read_parts(const std::vector<ExrPartPlanes>& parts, int threads, const RowsDone& done = {}) const;

  /// Reads channels that are not subsampled, of any type; integers as integers only.
  void read_typed(int part, const std::vector<ExrTypedPlane>& planes) const;

 private:
  std::string where(int part) const;

  /// Decodes every pixel into one row of memory where the file is so small for what it declares that it is
  /// likely to lie: whoever reads it next allocates the whole.
  void check_pixels() const;
  /// Rows follow one another as pixels do, or all go to one row.
  enum class Rows { follow, same };
  void read_rows(int part, const std::vector<ExrTypedPlane>& planes, Rows rows) const;
  void require_room(int part, const std::string& channel, size_t count, size_t needed) const;
  void read_with_openexr(int part, const std::vector<ExrPlane>& planes) const;

  std::string path_;
  ExrChunks chunks_;
  std::unique_ptr<Imf::MultiPartInputFile> file_;
};

/// The part that holds a file's picture: the only one with R, G and B, else the one that is called like a
/// picture (mean, denoised, C, beauty, ...): renderers write normals and other guides as R, G and B, too.
/// Samples are no pictures. Throws Error where there is none and where several may be it.
int picture_part(const ExrReader& exr);

/// R, G, B of that part as they stand there. Throws Error when the file is damaged.
Image read_rgb(const ExrReader& exr);

}  // namespace ld
