// Pixels of an OpenEXR part straight from the file's chunks to planes of floats. OpenEXR itself decodes the
// chunks of a file one after the other, keeps all channels of a chunk as half floats in between and converts
// them one by one.
#pragma once

#include <ImfChannelList.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "frame/exr_check.h"

namespace ld {

struct ExrPlane;

/// A file that several threads may read at once.
class ExrFile {
 public:
  /// Throws Error when it cannot be opened.
  explicit ExrFile(const std::string& path);
  ~ExrFile();
  ExrFile(const ExrFile&) = delete;
  ExrFile& operator=(const ExrFile&) = delete;

  /// Whether all of these bytes are there.
  bool read(void* to, size_t bytes, uint64_t offset) const;

 private:
  int file_;
};

/// A part in bands of rows that may be read in any order, on any threads.
class ExrUnpacker {
 public:
  /// Planes that are as large as the part, of channels of half floats or floats; they, the file and its
  /// chunks must live as long as the unpacker. `path` is for complaints. Nothing for parts that OpenEXR has
  /// to decode: of another compression than none, ZIPS and ZIP, with mip maps or subsampled channels.
  static std::unique_ptr<const ExrUnpacker> make(const ExrFile& file, const std::string& path,
                                                 const ExrChunks& chunks, size_t part,
                                                 const Imf::ChannelList& channels,
                                                 const std::vector<ExrPlane>& planes);
  virtual ~ExrUnpacker() = default;

  virtual int bands() const = 0;
  /// Returns the first row and the number of rows of the band. Throws Error where a chunk is damaged.
  virtual std::pair<int, int> read(int band) const = 0;
};

}  // namespace ld
