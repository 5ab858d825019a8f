#include "render/shading/texture_image.h"

#include <algorithm>

#include "core/tone_map.h"
#include "frame/picture_formats.h"

namespace ld {
namespace {

constexpr int kMaxSide = 16384;

std::shared_ptr<const TextureImage> to_texture(const DecodedPicture& picture, TextureUse use) {
  const bool decode = use == TextureUse::colour && picture.small_integers;
  const auto number = [&](float x) {
    if (!(x > 0) || !std::isfinite(x)) return 0.0F;
    return decode ? srgb_inverse(x) : x;
  };
  auto image = std::make_shared<TextureImage>();
  image->width = picture.width;
  image->height = picture.height;
  const auto channels = static_cast<size_t>(picture.channels);
  image->texels.resize(picture.pixels.size() / channels);
  for (size_t i = 0; i < image->texels.size(); ++i) {
    const float* p = &picture.pixels[i * channels];
    Vec3& texel = image->texels[i];
    if (use == TextureUse::alpha)
      texel = grey(picture.alpha < 0 ? 1.0F : number(p[picture.alpha]));
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
  return to_texture(picture_formats().read(path, kMaxSide), use);
}

std::shared_ptr<const TextureImage> decode_texture_image(const std::vector<uint8_t>& bytes,
                                                         const std::string& name, TextureUse use) {
  return to_texture(picture_formats().decode(bytes, name, kMaxSide), use);
}

}  // namespace ld
