// A check of OpenEXR files before the OpenEXR library sees them. A header of a few hundred bytes can declare
// gigabytes, and the library allocates what headers declare; the installed 3.1 has known faults with deep
// data, and it leaves pixels undefined, without a complaint, where a chunk unpacks to fewer bytes than the
// header promises.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "frame/exr_raw_header.h"

namespace ld {

constexpr int kMaxImageSide = 16384;
constexpr int kMaxSamples = 4096;                       // a pixel
constexpr int64_t kMaxFrameSamples = int64_t{1} << 30;  // pixels times samples a pixel
constexpr int kMaxExrParts = kMaxSamples + 64;

/// Where the chunks of a file's pixels are.
struct ExrChunks {
  bool multi_part = false;
  std::vector<ExrRawPart> parts;
  /// For each part, from top to bottom, tiles from left to right; none from a part with mip maps on.
  std::vector<std::vector<uint64_t>> offsets;
};

/// Lines in a chunk of a part that is not tiled.
int lines_of_chunk(const ExrRawPart& part);

/// Throws Error when the file is missing, a folder, not an OpenEXR file, deep, of an absurd size, cut short,
/// incomplete, smaller than its pixels can be compressed to, or when the chunks of a part are not of the size
/// its header says.
ExrChunks check_exr_file(const std::filesystem::path& path);

[[noreturn]] void fail_deep(const std::string& path);

}  // namespace ld
