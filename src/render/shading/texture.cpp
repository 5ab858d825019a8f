#include "render/shading/texture.h"

#include "render/shading/patterns.h"

namespace ld {
namespace {

/// The two coordinates of p (in the texture's axes) that lie across the axis the surface faces most.
Vec2 project_from_box(Vec3 p, Vec3 normal) {
  const float x = std::abs(normal.x), y = std::abs(normal.y), z = std::abs(normal.z);
  if (x >= y && x >= z) return {p.z, p.y};
  return y >= z ? Vec2{p.x, p.z} : Vec2{p.x, p.y};
}

}  // namespace

Vec3 Texture::evaluate(const TexturePoint& point) const {
  if (pattern == Pattern::plain) return colour_a;
  const Vec3 local = orientation.to_local(point.position) * frequency;
  if (pattern != Pattern::image) {
    // The offset keeps lattice planes off the faces of axis-aligned walls, where rounding would speckle them.
    return mix(colour_a, colour_b, pattern_value(pattern, local + Vec3{0.37F, 0.41F, 0.43F}, seed));
  }
  const Vec2 uv = point.has_uv ? point.uv : project_from_box(local, orientation.to_local(point.normal));
  return colour_a * image->bilinear(uv.x * static_cast<float>(image->width),
                                    (1 - uv.y) * static_cast<float>(image->height), false);
}

Texture plain_texture(Vec3 colour) {
  Texture texture;
  texture.colour_a = texture.colour_b = colour;
  return texture;
}

Texture image_texture(std::shared_ptr<const TextureImage> image, Vec3 factor) {
  Texture texture = plain_texture(factor);
  texture.pattern = Pattern::image;
  texture.image = std::move(image);
  return texture;
}

}  // namespace ld
