#include "inference/picture_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImfThreading.h>
#include <half.h>

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "core/file_io.h"
#include "frame/exr_output.h"
#include "frame/exr_reader.h"
#include "frame/frame_attributes.h"
#include "frame/half_range.h"
#include "frame/picture_place.h"
#include "import/former_result.h"

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
    for (size_t p = 0; p < count; ++p) out[p] = half(std::clamp(pixels[p], -kHalfMax, kHalfMax));
  }
  return channel;
}

/// The channels of an image, of which the first three may be a colour; `beyond` counts those that half floats
/// do not reach.
std::vector<Channel> channels_of(Image image, const std::vector<std::string>& names, bool full_float,
                                 int64_t& beyond) {
  const size_t pixels = image.plane_size();
  if (!full_float && image.channels >= 3)
    beyond += fit_colours_in_half(image.plane(0), image.plane(1), image.plane(2), pixels);
  std::vector<Channel> channels;
  for (int c = 0; c < image.channels; ++c)
    channels.push_back(channel_of(names[static_cast<size_t>(c)], image.plane(c), pixels, full_float));
  return channels;
}

/// The original's channels that are kept of one of its parts, as they stand there, placed in `extent`.
std::vector<Channel> kept_channels(const ExrReader& exr, const Original& original, int part,
                                   const Extent& extent, std::vector<std::string>& notes) {
  std::vector<Channel> channels;
  std::string subsampled;
  const size_t pixels = static_cast<size_t>(exr.width(part)) * static_cast<size_t>(exr.height(part));
  const Imf::ChannelList& list = exr.header(part).channels();
  for (auto it = list.begin(); it != list.end(); ++it) {
    if (original.replaced.count({part, it.name()}) > 0) continue;
    if (it.channel().xSampling != 1 || it.channel().ySampling != 1) {
      subsampled += (subsampled.empty() ? "" : ", ") + std::string(it.name());
      continue;
    }
    channels.push_back({it.name(), it.channel().type, {}});
    channels.back().bytes.resize(pixels * bytes_of(it.channel().type));
  }
  if (!subsampled.empty())
    notes.push_back("not kept, because they do not have every pixel: the channels " + subsampled);
  std::vector<ExrTypedPlane> planes;
  for (Channel& channel : channels)
    planes.push_back({channel.name, channel.type, channel.bytes.data(), pixels});
  if (!planes.empty()) exr.read_typed(part, planes);
  const Extent own = extent_of(exr, part);
  if (own.windows.x == extent.windows.x && own.windows.y == extent.windows.y && own.width == extent.width &&
      own.height == extent.height)
    return channels;
  for (Channel& channel : channels) {
    std::vector<char> placed(extent.pixels() * bytes_of(channel.type));
    place_pixels(channel.bytes.data(), own, placed.data(), extent, bytes_of(channel.type));
    channel.bytes = std::move(placed);
  }
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

/// A render's radiance need not be called R, G and B, which other channels of its part may be.
void make_way(std::vector<Channel>& kept, const Part& part, std::vector<std::string>& notes) {
  std::set<std::string> names;
  for (const Channel& channel : part.channels) names.insert(channel.name);
  for (const Channel& channel : kept) names.insert(channel.name);
  for (Channel& channel : kept) {
    if (part.header.channels().findChannel(channel.name) == nullptr) continue;
    const std::string taken = channel.name;
    while (!names.insert(channel.name).second) channel.name = "input." + channel.name;
    notes.push_back(
        fmt::format("'{}' is the denoised picture's, so the input's channel of that name is kept as '{}'",
                    taken, channel.name));
  }
}

/// OpenEXR's own threads, while it lives; they change no byte of a file.
class WritingThreads {
 public:
  explicit WritingThreads(int threads) { Imf::setGlobalThreadCount(threads > 1 ? threads : 0); }
  ~WritingThreads() { Imf::setGlobalThreadCount(0); }
  WritingThreads(const WritingThreads&) = delete;
  WritingThreads& operator=(const WritingThreads&) = delete;
};

void write_parts(const fs::path& temporary, const fs::path& path, const std::vector<Part>& parts,
                 int threads) {
  const WritingThreads writing(threads);
  std::vector<Imf::Header> headers;
  for (const Part& part : parts) headers.push_back(part.header);
  write_exr_file(temporary, path, [&](Imf::OStream& stream) {
    // What OpenEXR wants to be the same in all parts (display window, chromaticities, ...) is the picture's.
    Imf::MultiPartOutputFile file(stream, headers.data(), int(headers.size()),
                                  /*overrideSharedAttributes=*/true, threads);
    for (size_t i = 0; i < parts.size(); ++i) {
      const Imath::Box2i& window = headers[i].dataWindow();
      Imf::FrameBuffer buffer;
      for (const Channel& channel : parts[i].channels)
        buffer.insert(channel.name, Imf::Slice::Make(channel.type, channel.bytes.data(), window));
      Imf::OutputPart output(file, int(i));
      output.setFrameBuffer(buffer);
      output.writePixels(window.max.y - window.min.y + 1);
    }
  });
}

}  // namespace

std::vector<std::string> write_picture(const fs::path& path, const PictureLayers& layers,
                                       const Original& original, const std::vector<PicturePart>& further,
                                       bool full_float, const std::string& by, int threads) {
  const ExrReader exr(original.file);
  const Image& picture = layers[0].second;
  std::vector<std::string> notes;
  int64_t beyond = 0;
  std::vector<Part> parts(1);
  Imf::Header& header = parts[0].header;
  header = header_with(picture.width, picture.height, original.windows);
  const Imath::Box2i window = header.dataWindow();
  copy_attributes(exr.header(original.part), header);
  header.insert(denoised_attribute(original.prefix), Imf::StringAttribute(by));
  header.compression() = Imf::ZIP_COMPRESSION;
  header.setType(Imf::SCANLINEIMAGE);
  header.setName("denoised");
  const Part empty = parts[0];
  for (const auto& [layer, image] : layers) {
    std::vector<std::string> channels;
    for (const char* name : {"R", "G", "B", "A"})
      channels.push_back((layer.empty() ? "" : layer + ".") + original.prefix + name);
    add_channels(parts[0], channels_of(image, channels, full_float, beyond));
  }
  if (original.samples.count(original.part) == 0) {
    std::vector<Channel> kept =
        kept_channels(exr, original, original.part, {picture.width, picture.height, original.windows}, notes);
    make_way(kept, parts[0], notes);
    add_channels(parts[0], std::move(kept));
  }

  for (const PicturePart& part : further) {
    parts.push_back(empty);
    parts.back().header.setName(part.name);
    const Imath::V2i first = window.min + Imath::V2i(part.x, part.y);
    parts.back().header.dataWindow() = {first,
                                        first + Imath::V2i(part.image.width - 1, part.image.height - 1)};
    add_channels(parts.back(), channels_of(part.image, part.channels, full_float, beyond));
  }

  std::set<std::string> names;
  for (const Part& part : parts) names.insert(part.header.name());
  std::ptrdiff_t before = 0;
  for (int part = 0; part < exr.parts(); ++part) {
    if (part == original.part || original.samples.count(part) > 0) continue;
    std::vector<Channel> kept = kept_channels(exr, original, part, extent_of(exr, part), notes);
    if (kept.empty()) continue;
    Part own{Imf::Header(exr.header(part).displayWindow(), exr.header(part).dataWindow()), {}};
    copy_attributes(exr.header(part), own.header);
    own.header.compression() = Imf::ZIP_COMPRESSION;
    own.header.setType(Imf::SCANLINEIMAGE);
    std::string name = exr.part_name(part);
    while (!names.insert(name).second) name += "_";  // a file that was denoised before has a part "denoised"
    own.header.setName(name);
    add_channels(own, std::move(kept));
    if (!original.leads && part < original.part)
      parts.insert(parts.begin() + before++, std::move(own));
    else
      parts.push_back(std::move(own));
  }
  write_atomically(path, [&](const fs::path& temporary) { write_parts(temporary, path, parts, threads); });
  if (beyond > 0)
    notes.push_back(
        fmt::format("{} colour channels are brighter than half floats reach (65504): darkened, with their "
                    "hue; --float keeps them",
                    beyond));
  return notes;
}

}  // namespace ld
