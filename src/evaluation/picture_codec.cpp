#include "evaluation/picture_codec.h"

#include <half.h>
#include <zlib.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/error.h"
#include "core/tone_map.h"
#include "frame/half_range.h"

namespace ld {
namespace {

uint16_t half_bits(float value) {
  return half(std::isfinite(value) ? std::clamp(value, -kHalfMax, kHalfMax) : value).bits();
}

std::string base64(const std::string& bytes) {
  constexpr const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t three = 0;
    for (size_t k = 0; k < 3; ++k)
      three = three << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0U);
    for (size_t k = 0; k < 4; ++k) text += i + k > bytes.size() ? '=' : kDigits[three >> (18 - 6 * k) & 63U];
  }
  return text;
}

std::string packed(const std::vector<uint8_t>& bytes) {
  uLongf size = compressBound(static_cast<uLong>(bytes.size()));
  std::string result(size, '\0');
  const int code = compress2(reinterpret_cast<Bytef*>(result.data()), &size, bytes.data(),
                             static_cast<uLong>(bytes.size()), Z_BEST_COMPRESSION);
  if (code != Z_OK)
    fail("zlib cannot compress {} bytes (code {}); is there memory left?", bytes.size(), code);
  result.resize(size);
  return base64(result);
}

}  // namespace

std::string encode_picture(const Image& image) {
  const size_t count = image.pixels.size(), width = static_cast<size_t>(image.width);
  std::vector<uint8_t> bytes(2 * count);
  unsigned previous = 0;
  for (size_t i = 0; i < count; ++i) {
    if (i % width == 0) previous = 0;
    const unsigned bits = half_bits(image.pixels[i]), difference = (bits - previous) & 0xffffU;
    previous = bits;
    bytes[i] = static_cast<uint8_t>(difference >> 8);
    bytes[count + i] = static_cast<uint8_t>(difference & 0xffU);
  }
  return packed(bytes);
}

std::string encode_shown_picture(const Image& image) {
  std::vector<uint8_t> bytes;
  bytes.reserve(image.pixels.size());
  unsigned previous = 0;
  for (size_t i = 0; i < image.pixels.size(); ++i) {
    if (i % static_cast<size_t>(image.width) == 0) previous = 0;
    const auto shown = static_cast<unsigned>(std::lround(255 * std::min(tone_map(image.pixels[i]), 1.0F)));
    bytes.push_back(static_cast<uint8_t>(shown - previous));
    previous = shown;
  }
  return packed(bytes);
}

}  // namespace ld
