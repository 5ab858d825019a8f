// Pictures as any renderer might write them: sizes, windows, order of parts, channels, types, compression,
// tiles and rows from below are drawn at random. What a pixel holds follows from its place, so that one in a
// wrong place is noticed.
#pragma once

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfStringAttribute.h>
#include <ImfTileDescription.h>
#include <ImfTiledOutputPart.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <map>
#include <random>
#include <string>
#include <vector>

namespace ld {

struct RandomChannel {
  Imf::PixelType type = Imf::FLOAT;
  int kind = 0;  // what it holds: 0..2 radiance of a sample, 3 alpha, others anything
  int sample = 0;
};

struct RandomPart {
  std::string name;
  Imath::Box2i window;
  std::map<std::string, RandomChannel> channels;
};

/// Eighths up to 16, which half floats hold.
inline float radiance_at(int x, int y, int sample, int channel) {
  return static_cast<float>(((x + 64) * 7 + (y + 64) * 13 + sample * 29 + channel * 3) % 128) / 8;
}
inline float alpha_at(int x, int y) {
  return static_cast<float>((x + 64 + 3 * (y + 64)) % 9) / 8;
}

/// The bits of a pixel, for a type of 2 or 4 bytes.
inline uint32_t pixel_bits(const RandomChannel& channel, int x, int y) {
  const uint32_t any = static_cast<uint32_t>(x + 64) * 2654435761U + static_cast<uint32_t>(y + 64) * 40503U +
                       static_cast<uint32_t>(channel.kind) * 977U;
  if (channel.type == Imf::UINT) return any;
  const float value = channel.kind < 3    ? radiance_at(x, y, channel.sample, channel.kind)
                      : channel.kind == 3 ? alpha_at(x, y)
                                          : static_cast<float>(any % 2000) / 8 - 100;
  uint32_t bits = 0;
  if (channel.type == Imf::HALF) return half(value).bits();
  std::memcpy(&bits, &value, sizeof bits);
  return bits;
}

class RandomPictures {
 public:
  explicit RandomPictures(uint32_t seed) : generator_(seed) {}

  int draw(int low, int high) {  // both ends included
    return low + static_cast<int>(generator_() % static_cast<uint32_t>(high - low + 1));
  }
  Imath::Box2i window() {
    const Imath::V2i corner(draw(-20, 20), draw(-20, 20));
    return {corner, corner + Imath::V2i(draw(0, 18), draw(0, 18))};
  }
  Imf::PixelType type(bool integers) {
    const int drawn = draw(0, integers ? 2 : 1);
    return drawn == 0 ? Imf::HALF : drawn == 1 ? Imf::FLOAT : Imf::UINT;
  }
  /// Channels of any name, with a layer or without, that nothing here takes for its own.
  void add_strangers(RandomPart& part, int most) {
    for (int i = draw(0, most); i > 0; --i)
      part.channels[(draw(0, 1) ? "crypto" : "aov" + std::to_string(draw(0, 99)) + ".x") +
                    std::to_string(i)] = {type(true), 100 + i, 0};
  }
  template <class T>
  void shuffle(std::vector<T>& values) {
    for (size_t i = values.size(); i > 1; --i)
      std::swap(values[i - 1], values[static_cast<size_t>(draw(0, static_cast<int>(i) - 1))]);
  }

  void write(const std::filesystem::path& path, const Imath::Box2i& display,
             const std::vector<RandomPart>& parts) {
    std::vector<Imf::Header> headers;
    for (const RandomPart& part : parts) {
      Imf::Header header(display, part.window);
      header.setName(part.name);
      header.insert("owner", Imf::StringAttribute("nobody"));
      const Imf::Compression lossless[] = {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION,
                                           Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION};
      header.compression() = lossless[draw(0, 4)];
      for (const auto& [name, channel] : part.channels)
        header.channels().insert(name, Imf::Channel(channel.type));
      if (draw(0, 2) == 0) {
        header.setType(Imf::TILEDIMAGE);
        header.setTileDescription(
            Imf::TileDescription(static_cast<unsigned>(draw(1, 16)), static_cast<unsigned>(draw(1, 16))));
      } else {
        header.setType(Imf::SCANLINEIMAGE);
        header.lineOrder() = draw(0, 1) ? Imf::DECREASING_Y : Imf::INCREASING_Y;
      }
      headers.push_back(header);
    }
    Imf::MultiPartOutputFile file(path.c_str(), headers.data(), static_cast<int>(headers.size()));
    for (size_t i = 0; i < parts.size(); ++i) write_part(file, static_cast<int>(i), headers[i], parts[i]);
  }

 private:
  static void write_part(Imf::MultiPartOutputFile& file, int index, const Imf::Header& header,
                         const RandomPart& part) {
    std::vector<std::vector<char>> planes;
    Imf::FrameBuffer buffer;
    for (const auto& [name, channel] : part.channels) {
      std::vector<char>& plane = planes.emplace_back();
      const size_t bytes = channel.type == Imf::HALF ? 2 : 4;
      for (int y = part.window.min.y; y <= part.window.max.y; ++y)
        for (int x = part.window.min.x; x <= part.window.max.x; ++x) {
          const uint32_t bits = pixel_bits(channel, x, y);
          const char* begin = reinterpret_cast<const char*>(&bits);
          plane.insert(plane.end(), begin, begin + bytes);
        }
      buffer.insert(name, Imf::Slice::Make(channel.type, plane.data(), part.window));
    }
    if (header.type() == Imf::TILEDIMAGE) {
      Imf::TiledOutputPart output(file, index);
      output.setFrameBuffer(buffer);
      output.writeTiles(0, output.numXTiles() - 1, 0, output.numYTiles() - 1);
    } else {
      Imf::OutputPart output(file, index);
      output.setFrameBuffer(buffer);
      output.writePixels(part.window.max.y - part.window.min.y + 1);
    }
  }

  std::mt19937 generator_;
};

/// The bits of a channel, row by row; empty where the part has no such channel of that type.
inline std::vector<uint32_t> channel_bits(const std::filesystem::path& path, int part,
                                          const std::string& name, Imf::PixelType type) {
  Imf::MultiPartInputFile file(path.c_str());
  const Imf::Header& header = file.header(part);
  const Imf::Channel* channel = header.channels().findChannel(name);
  if (channel == nullptr || channel->type != type) return {};
  const Imath::Box2i window = header.dataWindow();
  const size_t count = static_cast<size_t>(window.size().x + 1) * static_cast<size_t>(window.size().y + 1);
  std::vector<uint16_t> halves(type == Imf::HALF ? count : 0);
  std::vector<uint32_t> bits(count);
  Imf::FrameBuffer buffer;
  void* target = type == Imf::HALF ? static_cast<void*>(halves.data()) : bits.data();
  buffer.insert(name, Imf::Slice::Make(type, target, window));
  Imf::InputPart input(file, part);
  input.setFrameBuffer(buffer);
  input.readPixels(window.min.y, window.max.y);
  if (type == Imf::HALF) std::copy(halves.begin(), halves.end(), bits.begin());
  return bits;
}

}  // namespace ld
