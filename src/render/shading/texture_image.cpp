#include "render/shading/texture_image.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>

#include "core/error.h"
#include "core/shown_text.h"
#include "core/tone_map.h"

namespace ld {
namespace {

constexpr int kMaxSide = 16384;

std::shared_ptr<const TextureImage> read_open(OIIO::ImageInput& input, const std::string& name,
                                              TextureUse use) {
  const OIIO::ImageSpec spec = input.spec();
  if (spec.width < 1 || spec.height < 1 || spec.width > kMaxSide || spec.height > kMaxSide ||
      spec.nchannels < 1)
    fail("{}: {} x {} pixels with {} channels; expected 1 to {} a side: make it smaller", name, spec.width,
         spec.height, spec.nchannels, kMaxSide);
  const auto channels = static_cast<size_t>(spec.nchannels);
  std::vector<float> pixels(static_cast<size_t>(spec.width) * static_cast<size_t>(spec.height) * channels);
  if (!input.read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, pixels.data()))
    fail("{}: cannot read its pixels: {}", name, one_line(input.geterror()));

  const bool decode =
      use == TextureUse::colour && spec.format.size() <= 2 && !spec.format.is_floating_point();
  const auto number = [&](float x) {
    if (!(x > 0) || !std::isfinite(x)) return 0.0F;
    return decode ? srgb_inverse(x) : x;
  };
  auto image = std::make_shared<TextureImage>();
  image->width = spec.width;
  image->height = spec.height;
  image->texels.resize(pixels.size() / channels);
  for (size_t i = 0; i < image->texels.size(); ++i) {
    const float* p = &pixels[i * channels];
    Vec3& texel = image->texels[i];
    if (use == TextureUse::alpha)
      texel = grey(spec.alpha_channel < 0 ? 1.0F : number(p[spec.alpha_channel]));
    else if (channels < 3)
      texel = grey(number(p[0]));
    else
      texel = {number(p[0]), number(p[1]), number(p[2])};
  }
  return image;
}

float unit_fraction(float x) {
  return x - std::floor(x);
}

}  // namespace

Vec3 TextureImage::bilinear(float x, float y, bool clamp_y) const {
  const auto w = static_cast<float>(width), h = static_cast<float>(height);
  // Wrapped to [0, w) first: whole numbers of turns may be beyond what an int holds.
  const float u = unit_fraction((x - 0.5F) / w) * w;
  const float v = clamp_y ? std::clamp(y - 0.5F, 0.0F, h - 1) : unit_fraction((y - 0.5F) / h) * h;
  const int x0 = std::min(static_cast<int>(u), width - 1), y0 = std::min(static_cast<int>(v), height - 1);
  const int x1 = x0 + 1 == width ? 0 : x0 + 1, y1 = y0 + 1 < height ? y0 + 1 : clamp_y ? y0 : 0;
  const auto texel = [&](int i, int j) {
    return texels[static_cast<size_t>(j) * static_cast<size_t>(width) + static_cast<size_t>(i)];
  };
  const float s = u - static_cast<float>(x0), t = v - static_cast<float>(y0);
  return mix(mix(texel(x0, y0), texel(x1, y0), s), mix(texel(x0, y1), texel(x1, y1), s), t);
}

std::shared_ptr<const TextureImage> read_texture_image(const std::filesystem::path& path, TextureUse use) {
  const auto input = OIIO::ImageInput::open(path.string());
  if (!input) fail("{}: cannot read it as a picture: {}", path.string(), one_line(OIIO::geterror()));
  return read_open(*input, path.string(), use);
}

std::shared_ptr<const TextureImage> decode_texture_image(const std::vector<uint8_t>& bytes,
                                                         const std::string& name, TextureUse use) {
  OIIO::Filesystem::IOMemReader memory(const_cast<uint8_t*>(bytes.data()), bytes.size());
  // OpenImageIO recognises formats by extension first; PNG and JPEG are what glTF allows.
  const bool png = bytes.size() > 1 && bytes[0] == 0x89 && bytes[1] == 'P';
  const auto input = OIIO::ImageInput::open(png ? "memory.png" : "memory.jpg", nullptr, &memory);
  if (!input) fail("{}: cannot read it as a PNG or JPEG picture: {}", name, one_line(OIIO::geterror()));
  return read_open(*input, name, use);
}

}  // namespace ld
