// Before OpenImageIO, which would otherwise build all of fmt into this file: the linker then takes this file,
// and with it OpenImageIO, into every program that formats text.
#include <fmt/format.h>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <half.h>

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

// In memory: written by OpenImageIO itself, a file that the disk has no room for would end early without a
// complaint.
std::string png_bytes(const fs::path& path, const Image& image) {
  check_image(path, image, 3);
  std::vector<uint8_t> pixels(image.pixels.size());
  const auto channels = static_cast<size_t>(image.channels);
  for (size_t c = 0; c < channels; ++c)
    for (size_t p = 0; p < image.plane_size(); ++p) {
      const float mapped = std::min(tone_map(image.pixels[c * image.plane_size() + p]), 1.0F);
      pixels[p * channels + c] = static_cast<uint8_t>(std::lround(mapped * 255.0F));
    }
  OIIO::ImageSpec spec(image.width, image.height, image.channels, OIIO::TypeDesc::UINT8);
  spec.attribute("oiio:ColorSpace", "sRGB");
  const auto output = OIIO::ImageOutput::create("png");
  if (!output) fail("cannot write {}: {}", path.string(), OIIO::geterror());
  OIIO::Filesystem::IOVecOutput memory;
  if (!output->set_ioproxy(&memory) || !output->open(path.string(), spec) ||
      !output->write_image(OIIO::TypeDesc::UINT8, pixels.data()) || !output->close())
    fail("cannot write {}: {}", path.string(), output->geterror());
  return {memory.buffer().begin(), memory.buffer().end()};
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
