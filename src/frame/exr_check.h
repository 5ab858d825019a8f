// A look at an OpenEXR file's raw header before the OpenEXR library sees it. A header of a few hundred bytes
// can declare gigabytes, and the library allocates what headers declare; the installed 3.1 also has known
// faults with deep data. Layout: "OpenEXR File Layout"
// (https://openexr.com/en/latest/OpenEXRFileLayout.html).
#pragma once

#include <cstdint>
#include <filesystem>

namespace ld {

constexpr int kMaxImageSide = 16384;
constexpr int kMaxSamples = 4096;                       // a pixel
constexpr int64_t kMaxImagePixels = int64_t{1} << 28;   // 16384 x 16384
constexpr int64_t kMaxFrameSamples = int64_t{1} << 30;  // pixels times samples a pixel
constexpr int kMaxExrParts = kMaxSamples + 64;

/// Throws Error when the file is missing, a folder, not an OpenEXR file, deep, of an absurd size, cut short,
/// incomplete, or smaller than its pixels can be compressed to.
void check_exr_file(const std::filesystem::path& path);

}  // namespace ld
