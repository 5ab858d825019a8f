#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <half.h>
#include <png.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/file_identity.h"
#include "core/file_io.h"
#include "core/tone_map.h"
#include "frame/exr_check.h"
#include "frame/exr_output.h"
#include "frame/frame_attributes.h"
#include "frame/frame_file.h"
#include "frame/half_range.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// Writes to `temporary`; complaints name `path`.
void write_exr(const fs::path& temporary, const fs::path& path, const Image& image, const Windows& windows,
               const ReferenceFloor& floor) {
  std::vector<std::string> channels = {"Y"};
  if (image.channels > 1) channels = {"R", "G", "B"};
  if (image.channels == 4) channels.emplace_back("A");
  Image fitted = image;
  if (image.channels > 1)
    fit_colours_in_half(fitted.plane(0), fitted.plane(1), fitted.plane(2), fitted.plane_size());
  std::vector<half> pixels(image.pixels.size());
  std::transform(fitted.pixels.begin(), fitted.pixels.end(), pixels.begin(),
                 [](float value) { return half(std::clamp(value, -kHalfMax, kHalfMax)); });
  Imf::Header header = header_with(image.width, image.height, windows);
  header.compression() = Imf::ZIP_COMPRESSION;
  write_floor(header, floor);
  Imf::FrameBuffer buffer;
  for (size_t c = 0; c < channels.size(); ++c) {
    header.channels().insert(channels[c], Imf::Channel(Imf::HALF));
    buffer.insert(channels[c],
                  Imf::Slice::Make(Imf::HALF, pixels.data() + c * image.plane_size(), header.dataWindow()));
  }
  write_exr_file(temporary, path, [&](Imf::OStream& stream) {
    Imf::OutputFile file(stream, header);
    file.setFrameBuffer(buffer);
    file.writePixels(image.height);
  });
}

void check_image(const fs::path& path, const Image& image, int most_channels) {
  if (image.width < 1 || image.height < 1 || image.width > kMaxImageSide || image.height > kMaxImageSide ||
      (image.channels != 1 && image.channels != 3 && image.channels != most_channels) ||
      image.pixels.size() != image.plane_size() * static_cast<size_t>(image.channels))
    fail(
        "cannot write {}: an image of {} x {} pixels with {} channels and {} numbers; expected 1 to {} "
        "pixels a side and "
        "1, 3 or, in EXR, 4 channels",
        path.string(), image.width, image.height, image.channels, image.pixels.size(), kMaxImageSide);
}

}  // namespace

std::string png_bytes(const fs::path& path, const Image& image) {
  check_image(path, image, 3);
  std::vector<uint8_t> pixels(image.pixels.size());
  const auto channels = static_cast<size_t>(image.channels);
  for (size_t c = 0; c < channels; ++c)
    for (size_t p = 0; p < image.plane_size(); ++p) {
      const float mapped = std::min(tone_map(image.pixels[c * image.plane_size() + p]), 1.0F);
      pixels[p * channels + c] = static_cast<uint8_t>(std::lround(mapped * 255.0F));
    }
  png_image png{};
  png.version = PNG_IMAGE_VERSION;
  png.width = static_cast<png_uint_32>(image.width);
  png.height = static_cast<png_uint_32>(image.height);
  png.format = image.channels == 1 ? PNG_FORMAT_GRAY : PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
  std::string bytes(size, '\0');
  if (png_image_write_to_memory(&png, bytes.data(), &size, /*convert_to_8_bit=*/0, pixels.data(),
                                /*row_stride=*/0, /*colormap=*/nullptr) == 0)
    fail("cannot write {}: {}", path.string(), png.message);
  bytes.resize(size);
  return bytes;
}

PictureFormat picture_format(const fs::path& path) {
  const std::string extension = lower_extension(path);
  if (extension == ".exr") return PictureFormat::exr;
  if (extension == ".png") return PictureFormat::png;
  fail_usage("cannot write {}: unknown extension '{}'; expected .exr (linear) or .png (tone-mapped)",
             path.string(), path.extension().string());
}

void write_image(const fs::path& path, const Image& image, const Windows& windows,
                 const ReferenceFloor& floor) {
  if (picture_format(path) == PictureFormat::png) {
    write_file_atomically(path, png_bytes(path, image));
    return;
  }
  check_image(path, image, 4);
  write_atomically(path,
                   [&](const fs::path& temporary) { write_exr(temporary, path, image, windows, floor); });
}

}  // namespace ld
