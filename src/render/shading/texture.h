// Textures: procedural solid ones, a colour for every point in space, and pictures.
#pragma once

#include <cstdint>
#include <memory>

#include "render/geometry/vec3.h"
#include "render/shading/texture_image.h"

namespace ld {

enum class Pattern {
  plain,
  checker,
  stripes,
  rings,
  dots,
  noise,
  marble,
  bricks,
  tiles,
  wood,
  weave,
  gradient,
  voronoi,
  cracks,
  glyphs,
  image
};

/// What of a surface point textures may ask for.
struct TexturePoint {
  Vec3 position;            // where the object stood at shutter open, scene units
  Vec3 normal = {0, 1, 0};  // of the triangle at that time, unit
  Vec2 uv;                  // v upwards
  bool has_uv = false;
};

struct Texture {
  Pattern pattern = Pattern::plain;
  Vec3 colour_a = {0.5F, 0.5F, 0.5F};
  Vec3 colour_b = {0.5F, 0.5F, 0.5F};
  Basis orientation;    // of the pattern's axes
  float frequency = 1;  // cells per scene unit
  uint32_t seed = 0;
  std::shared_ptr<const TextureImage> image;  // of Pattern::image

  /// Between the two colours. Pattern::image: colour_a times the picture, by the texture coordinates where
  /// the mesh has them, else projected along the axis that the surface faces most, one picture a cell.
  Vec3 evaluate(const TexturePoint& point) const;
};

Texture plain_texture(Vec3 colour);
/// Factor times the picture.
Texture image_texture(std::shared_ptr<const TextureImage> image, Vec3 factor = {1, 1, 1});

}  // namespace ld
