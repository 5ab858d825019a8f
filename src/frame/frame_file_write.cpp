#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfPartType.h>
#include <ImfTiledOutputPart.h>
#include <half.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <set>

#include "core/error.h"
#include "core/file_io.h"
#include "frame/exr_check.h"
#include "frame/exr_output.h"
#include "frame/frame_attributes.h"
#include "frame/frame_file.h"
#include "frame/half_range.h"
#include "frame/half_rows.h"

namespace ld {
namespace {

constexpr int kTileSide = 64;

void check_frame(const std::filesystem::path& path, const Frame& frame) {
  if (frame.width < 1 || frame.height < 1 || frame.spp < 1 || frame.width > kMaxImageSide ||
      frame.height > kMaxImageSide || frame.spp > kMaxSamples)
    fail(
        "cannot write {}: a frame of {} x {} pixels with {} samples; expected 1 to {} pixels a side and 1 to "
        "{} samples",
        path.string(), frame.width, frame.height, frame.spp, kMaxImageSide, kMaxSamples);
  const size_t expected = frame.plane_size() * static_cast<size_t>(frame.spp);
  const auto channels = static_cast<size_t>(frame.channels);
  if (frame.valid.size() != expected || frame.samples.size() != expected * channels)
    fail("cannot write {}: the frame's buffers hold {} samples and {} mask entries; expected {}",
         path.string(), frame.samples.size() / channels, frame.valid.size(), expected);
  if (!frame.alpha.empty() && frame.alpha.size() != expected)
    fail("cannot write {}: the frame has alpha for {} samples; expected {} or none", path.string(),
         frame.alpha.size(), expected);
  if (frame_channels(frame.features) > frame.channels)
    fail("cannot write {}: the frame has {} channels a sample; expected {} for its features", path.string(),
         frame.channels, kAllChannels);
  std::set<std::string> names(frame.features.begin(), frame.features.end());
  names.insert("mean");
  for (const LightPart& part : frame.parts) {
    if (part.samples.size() != 3 * expected)
      fail("cannot write {}: the light part '{}' has {} values; expected {}", path.string(), part.name,
           part.samples.size(), 3 * expected);
    if (part.name.empty() || !names.insert(part.name).second)
      fail(
          "cannot write {}: '{}' cannot be the name of a light part; expected one that no feature and no "
          "other part has",
          path.string(), part.name);
  }
  if (!frame.holds("radiance")) fail("cannot write {}: the frame holds no radiance", path.string());
}

/// What the samples hold that the file cannot, or that a reader mends.
struct Unusual {
  bool beyond_half = false, mended = false;
};

Unusual unusual_samples(const Frame& frame) {
  Unusual found;
  for (int s = 0; s < frame.spp; ++s) {
    const uint8_t* valid = frame.valid_plane(s);
    for (int c = 0; c < frame.channels; ++c) {
      const float* plane = frame.plane(s, c);
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        if (valid[p] == 0) continue;
        if (!std::isfinite(plane[p]) || (c < 3 && plane[p] < 0)) found.mended = true;
        if (c < 3 && plane[p] > kHalfMax) found.beyond_half = true;
      }
    }
  }
  return found;
}

/// A channel of a file: its name there and where that of sample 0 begins; then every `stride` floats those of
/// the next.
struct StoredChannel {
  std::string name;
  const float* first = nullptr;
  size_t stride = 0;
  Imf::PixelType type = Imf::HALF;
  bool masks = false;  // NaN where the sample does not count
};

/// [channels, H, W] in their order; ids apart.
struct StoredPlanes {
  std::vector<half> halves;
  std::vector<float> ids;
};

/// The mean that a reader of the file would find, up to half's precision.
Image stored_mean(const Frame& frame, bool mended) {
  if (!mended) return mean_radiance(frame);
  Frame copy = frame;
  sanitise(copy);
  return mean_radiance(copy);
}

Imf::Header part_header(const Frame& frame, const std::string& name,
                        const std::vector<StoredChannel>& channels) {
  Imf::Header header = header_with(frame.width, frame.height, frame.info.windows);
  header.setName(name);
  header.setType(Imf::TILEDIMAGE);
  header.compression() = Imf::ZIP_COMPRESSION;
  header.setTileDescription(Imf::TileDescription(kTileSide, kTileSide, Imf::ONE_LEVEL));
  for (const StoredChannel& channel : channels)
    header.channels().insert(channel.name, Imf::Channel(channel.type));
  return header;
}

void write_part(Imf::MultiPartOutputFile& file, int part, const std::vector<StoredChannel>& channels,
                const StoredPlanes& planes) {
  const Imath::Box2i& window = file.header(part).dataWindow();
  const size_t plane_size =
      static_cast<size_t>(window.size().x + 1) * static_cast<size_t>(window.size().y + 1);
  Imf::FrameBuffer buffer;
  const half* halves = planes.halves.data();
  for (const StoredChannel& channel : channels) {
    if (channel.type == Imf::FLOAT) {
      buffer.insert(channel.name, Imf::Slice::Make(Imf::FLOAT, planes.ids.data(), window));
      continue;
    }
    buffer.insert(channel.name, Imf::Slice::Make(Imf::HALF, halves, window));
    halves += plane_size;
  }
  Imf::TiledOutputPart output(file, part);
  output.setFrameBuffer(buffer);
  output.writeTiles(0, output.numXTiles() - 1, 0, output.numYTiles() - 1);
}

std::vector<StoredChannel> sample_channels(const Frame& frame) {
  std::vector<StoredChannel> channels;
  const size_t pixels = frame.plane_size();
  for (const Feature& feature : feature_schema())
    if (frame.holds(feature.name))
      for (int c = 0; c < feature.channels; ++c)
        // Half floats hold whole numbers up to 2048 exactly, no further.
        channels.push_back({feature.exr_channels[static_cast<size_t>(c)], frame.plane(0, feature.offset + c),
                            static_cast<size_t>(frame.channels) * pixels,
                            feature.offset == kIdOffset ? Imf::FLOAT : Imf::HALF,
                            feature.offset == kRadianceOffset});
  if (!frame.alpha.empty()) channels.push_back({"A", frame.alpha.data(), pixels});
  for (size_t part = 0; part < frame.parts.size(); ++part)
    for (int c = 0; c < 3; ++c)
      channels.push_back({frame.parts[part].name + "." + "RGB"[c], frame.part_plane(part, 0, c), 3 * pixels});
  return channels;
}

StoredPlanes sample_planes(const Frame& frame, int sample, const std::vector<StoredChannel>& channels) {
  const size_t pixels = frame.plane_size();
  StoredPlanes planes;
  planes.halves.resize(pixels * channels.size());
  const uint8_t* valid = frame.valid_plane(sample);
  half* out = planes.halves.data();
  for (const StoredChannel& channel : channels) {
    const float* plane = channel.first + static_cast<size_t>(sample) * channel.stride;
    if (channel.type == Imf::FLOAT) {
      planes.ids.resize(pixels);
      for (size_t p = 0; p < pixels; ++p) planes.ids[p] = valid[p] != 0 ? plane[p] : 0.0F;
      continue;
    }
    const half masked = channel.masks ? std::numeric_limits<half>::quiet_NaN() : half(0.0F);
    for (size_t p = 0; p < pixels; ++p) *out++ = valid[p] != 0 ? to_half(plane[p]) : masked;
  }
  return planes;
}

/// A frame whose radiance fits half floats; `clamped` of its channels did not before.
int64_t write_fitting(const std::filesystem::path& path, const Frame& frame, bool mended, int64_t clamped) {
  Image mean = stored_mean(frame, mended);
  if (!frame.alpha.empty()) {
    const Image alpha = mean_alpha(frame);
    mean.pixels.insert(mean.pixels.end(), alpha.pixels.begin(), alpha.pixels.end());
  }
  FrameInfo info = frame.info;
  info.clamped += clamped;
  if (info.depth_scale <= 0) info.depth_scale = median_depth(frame);

  std::vector<StoredChannel> mean_channels = {{"R"}, {"G"}, {"B"}};
  if (!frame.alpha.empty()) mean_channels.push_back({"A"});
  const std::vector<StoredChannel> channels = sample_channels(frame);

  std::vector<Imf::Header> headers = {part_header(frame, "mean", mean_channels)};
  write_attributes(headers[0], info, frame.spp);
  for (int s = 0; s < frame.spp; ++s)
    headers.push_back(part_header(frame, fmt::format("s{:03}", s), channels));

  write_atomically(path, [&](const std::filesystem::path& temporary) {
    write_exr_file(temporary, path, [&](Imf::OStream& stream) {
      Imf::MultiPartOutputFile file(stream, headers.data(), static_cast<int>(headers.size()));
      StoredPlanes mean_planes;
      mean_planes.halves.resize(mean.pixels.size());
      std::transform(mean.pixels.begin(), mean.pixels.end(), mean_planes.halves.begin(), to_half);
      write_part(file, 0, mean_channels, mean_planes);
      for (int s = 0; s < frame.spp; ++s)
        write_part(file, s + 1, channels, sample_planes(frame, s, channels));
    });
  });
  return clamped;
}

}  // namespace

int64_t write_frame(const std::filesystem::path& path, const Frame& frame) {
  check_frame(path, frame);
  const Unusual unusual = unusual_samples(frame);
  if (!unusual.beyond_half) return write_fitting(path, frame, unusual.mended, 0);
  Frame fitted = frame;
  int64_t clamped = 0;
  for (int s = 0; s < frame.spp; ++s) clamped += fit_in_half(fitted, s);
  return write_fitting(path, fitted, unusual.mended, clamped);
}

}  // namespace ld
