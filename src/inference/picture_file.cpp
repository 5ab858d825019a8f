#include "inference/picture_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "core/error.h"
#include "core/file_io.h"
#include "frame/exr_reader.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// A channel's pixels in the type of the file.
struct Channel {
  std::string name;
  Imf::PixelType type;
  std::vector<char> bytes;
};

size_t bytes_of(Imf::PixelType type) {
  return type == Imf::HALF ? 2 : 4;
}

Channel channel_of(const std::string& name, const float* pixels, size_t count, bool full_float) {
  Channel channel{name, full_float ? Imf::FLOAT : Imf::HALF, {}};
  channel.bytes.resize(count * bytes_of(channel.type));
  if (full_float) {
    std::copy_n(reinterpret_cast<const char*>(pixels), channel.bytes.size(), channel.bytes.data());
  } else {
    half* out = reinterpret_cast<half*>(channel.bytes.data());
    for (size_t p = 0; p < count; ++p) out[p] = half(std::clamp(pixels[p], -65504.0F, 65504.0F));
  }
  return channel;
}

/// The original's channels that are kept, as they stand there.
std::vector<Channel> kept_channels(const ExrReader& exr, const Original& original, const Image& picture) {
  std::vector<Channel> channels;
  if (!original.keep_channels || exr.width(original.part) != picture.width ||
      exr.height(original.part) != picture.height)
    return channels;
  const Imf::ChannelList& list = exr.header(original.part).channels();
  for (auto it = list.begin(); it != list.end(); ++it) {
    const std::string name = it.name();
    if (std::find(original.replaced.begin(), original.replaced.end(), name) != original.replaced.end())
      continue;
    if (name == "R" || name == "G" || name == "B" || (name == "A" && picture.channels == 4)) continue;
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1) continue;
    channels.push_back({name, it.channel().type, {}});
    channels.back().bytes.resize(picture.plane_size() * bytes_of(it.channel().type));
  }
  std::vector<ExrTypedPlane> planes;
  for (Channel& channel : channels) planes.push_back({channel.name, channel.type, channel.bytes.data()});
  if (!planes.empty()) exr.read_typed(original.part, planes);
  return channels;
}

/// Copies what a header says of the picture, but not how its file is made nor what samples it came from.
void copy_attributes(const Imf::Header& from, Imf::Header& to) {
  static const std::set<std::string> left_out = {
      "channels", "compression", "dataWindow",      "displayWindow", "lineOrder", "tiles",
      "name",     "type",        "version",         "chunkCount",    "preview",   "maxSamplesPerPixel",
      "ldSpp",    "ldClamped",   "ldSchemaVersion", "ldDepthScale"};
  for (auto it = from.begin(); it != from.end(); ++it)
    if (left_out.count(it.name()) == 0) to.insert(it.name(), it.attribute());
}

struct Part {
  Imf::Header header;
  std::vector<Channel> channels;
};

void add_channels(Part& part, std::vector<Channel> channels) {
  for (Channel& channel : channels) {
    part.header.channels().insert(channel.name, Imf::Channel(channel.type));
    part.channels.push_back(std::move(channel));
  }
}

void write_parts(const fs::path& temporary, const fs::path& path, const std::vector<Part>& parts) {
  std::vector<Imf::Header> headers;
  for (const Part& part : parts) headers.push_back(part.header);
  try {
    Imf::MultiPartOutputFile file(temporary.c_str(), headers.data(), int(headers.size()));
    for (size_t i = 0; i < parts.size(); ++i) {
      const Imath::Box2i& window = headers[i].dataWindow();
      Imf::FrameBuffer buffer;
      for (const Channel& channel : parts[i].channels)
        buffer.insert(channel.name, Imf::Slice::Make(channel.type, channel.bytes.data(), window));
      Imf::OutputPart output(file, int(i));
      output.setFrameBuffer(buffer);
      output.writePixels(window.max.y - window.min.y + 1);
    }
  } catch (const std::exception& error) {
    fail("cannot write {}: {}; is the disk full?", path.string(), error.what());
  }
}

}  // namespace

void write_picture(const fs::path& path, const Image& picture, const Original& original,
                   const std::vector<PicturePart>& further, bool full_float, const std::string& by) {
  const ExrReader exr(original.file);
  const Imf::Header& source = exr.header(original.part);
  const Imath::V2i corner = source.dataWindow().min;
  const auto window_at = [&](int x, int y, const Image& image) {
    const Imath::V2i first(corner.x + x, corner.y + y);
    return Imath::Box2i(first, first + Imath::V2i(image.width - 1, image.height - 1));
  };

  std::vector<Part> parts(1);
  parts[0].header = Imf::Header(source.displayWindow(), window_at(0, 0, picture));
  Imf::Header& header = parts[0].header;
  copy_attributes(source, header);
  header.insert("ldDenoisedBy", Imf::StringAttribute(by));
  header.compression() = Imf::ZIP_COMPRESSION;
  header.setType(Imf::SCANLINEIMAGE);
  header.setName("denoised");
  const Part empty = parts[0];
  std::vector<Channel> colour;
  for (int c = 0; c < picture.channels; ++c)
    colour.push_back(
        channel_of(std::string(1, "RGBA"[c]), picture.plane(c), picture.plane_size(), full_float));
  add_channels(parts[0], std::move(colour));
  add_channels(parts[0], kept_channels(exr, original, picture));

  for (const PicturePart& part : further) {
    parts.push_back(empty);
    parts.back().header.setName(part.name);
    parts.back().header.dataWindow() = window_at(part.x, part.y, part.image);
    std::vector<Channel> channels;
    for (int c = 0; c < part.image.channels; ++c)
      channels.push_back(
          channel_of(part.channels[size_t(c)], part.image.plane(c), part.image.plane_size(), full_float));
    add_channels(parts.back(), std::move(channels));
  }
  write_atomically(path, [&](const fs::path& temporary) { write_parts(temporary, path, parts); });
}

}  // namespace ld
