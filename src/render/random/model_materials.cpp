#include "render/random/model_materials.h"

#include "render/random/random_materials.h"
#include "render/shading/metals.h"

namespace ld {
namespace {

/// A colour near one of a palette's.
template <size_t N>
Vec3 near(RandomStream& random, const Vec3 (&palette)[N], float spread) {
  const Vec3 base = palette[random.below(N)];
  const float shade = random.uniform(1 - spread, 1 + spread), warm = random.uniform(-0.1F, 0.1F);
  const Vec3 c = base * shade * Vec3{1 + warm, 1, 1 - warm};
  return {std::clamp(c.x, 0.02F, 0.92F), std::clamp(c.y, 0.02F, 0.92F), std::clamp(c.z, 0.02F, 0.92F)};
}

constexpr Vec3 kWoods[] = {{0.42F, 0.24F, 0.11F},
                           {0.55F, 0.36F, 0.18F},
                           {0.25F, 0.13F, 0.06F},
                           {0.68F, 0.5F, 0.3F},
                           {0.35F, 0.3F, 0.25F}};
constexpr Vec3 kLeaves[] = {{0.12F, 0.32F, 0.06F}, {0.25F, 0.42F, 0.08F}, {0.07F, 0.2F, 0.07F},
                            {0.35F, 0.4F, 0.15F},  {0.55F, 0.28F, 0.05F}, {0.5F, 0.1F, 0.06F}};
constexpr Vec3 kStones[] = {{0.5F, 0.48F, 0.45F},
                            {0.32F, 0.3F, 0.29F},
                            {0.62F, 0.55F, 0.45F},
                            {0.4F, 0.28F, 0.22F},
                            {0.75F, 0.73F, 0.7F}};
constexpr Vec3 kPaints[] = {{0.82F, 0.81F, 0.78F}, {0.75F, 0.7F, 0.6F},   {0.6F, 0.66F, 0.7F},
                            {0.66F, 0.7F, 0.58F},  {0.78F, 0.62F, 0.55F}, {0.45F, 0.48F, 0.52F}};

Texture between(Pattern pattern, Vec3 a, Vec3 b, const Basis& orientation, float frequency,
                RandomStream& random) {
  Texture texture;
  texture.pattern = pattern;
  texture.colour_a = a;
  texture.colour_b = b;
  texture.orientation = orientation;
  texture.frequency = frequency;
  texture.seed = random.bits();
  return texture;
}

/// Any pattern in any colours, fitting something of this size; or one of the user's pictures.
Texture any_texture(SceneBuilder& builder, float size) {
  RandomStream& random = builder.random;
  if (builder.assets->has_textures() && builder.from_assets()) {
    const auto picture = builder.assets->texture(random);
    Texture texture = image_texture(picture, chance(random, 0.7) ? grey(1) : random_colour(random));
    texture.orientation = random_rotation(random);
    texture.frequency = log_uniform(random, 0.3F, 3) / size;
    return texture;
  }
  constexpr Pattern kPatterns[] = {
      Pattern::plain, Pattern::plain,    Pattern::checker, Pattern::stripes, Pattern::rings, Pattern::dots,
      Pattern::noise, Pattern::noise,    Pattern::marble,  Pattern::bricks,  Pattern::tiles, Pattern::wood,
      Pattern::weave, Pattern::gradient, Pattern::voronoi, Pattern::cracks,  Pattern::glyphs};
  const Pattern pattern = kPatterns[random.below(17)];
  const Vec3 a = random_colour(random);
  const Vec3 b = chance(random, 0.5) ? random_colour(random) : a * random.uniform(0.15F, 0.7F);
  const Basis turn = random_rotation(random);
  float frequency = log_uniform(random, 1, 16) / size;
  if (pattern == Pattern::weave || pattern == Pattern::glyphs) frequency *= 3;
  return between(pattern, a, b, turn, frequency, random);
}

Texture roughness_texture(float size, RandomStream& random) {
  constexpr Pattern kPatterns[] = {Pattern::noise, Pattern::marble, Pattern::voronoi, Pattern::checker,
                                   Pattern::cracks};
  const Pattern pattern = kPatterns[random.below(5)];
  const Basis turn = random_rotation(random);
  const float frequency = log_uniform(random, 1, 8) / size;
  return between(pattern, grey(1), grey(random.uniform(0.2F, 0.7F)), turn, frequency, random);
}

Material diffuse(const Texture& colour) {
  Material material;
  material.colour = colour;
  return material;
}

Material plastic(const Texture& colour, float size, RandomStream& random) {
  Material material = diffuse(colour);
  material.kind = MaterialKind::plastic;
  material.roughness = chance(random, 0.3) ? 0 : random.uniform(0.1F, 0.6F);
  material.ior = random.uniform(1.35F, 1.65F);
  if (material.roughness > 0 && chance(random, 0.3)) material.roughness_map = roughness_texture(size, random);
  return material;
}

void make_real_metal(Material& material, RandomStream& random) {
  const Metal& metal = metals()[random.below(static_cast<uint32_t>(metals().size()))];
  material.metal_eta = metal.eta;
  material.metal_k = metal.k;
  material.colour = plain_texture(grey(0.9F));
}

Material metal(SceneBuilder& builder, float size) {
  RandomStream& random = builder.random;
  Material material;
  const float kind = random.uniform();
  if (kind < 0.08F) {
    material.kind = MaterialKind::mirror;
    material.roughness = 0;
  } else if (kind < 0.22F) {
    material.kind = MaterialKind::coated_metal;
    material.base_roughness = random.uniform(0.2F, 0.7F);
    material.roughness = chance(random, 0.6) ? 0 : random.uniform(0.1F, 0.4F);
  } else {
    material.kind = MaterialKind::rough_conductor;
    material.roughness = random.uniform(0.12F, 0.7F);
    if (chance(random, 0.3)) material.roughness_map = roughness_texture(size, random);
  }
  if (material.kind != MaterialKind::mirror && chance(random, 0.25))
    material.colour = any_texture(builder, size);  // anodised, painted
  else
    make_real_metal(material, random);
  return material;
}

Material glass(RandomStream& random) {
  Material material;
  material.ior = random.uniform(1.3F, 1.7F);
  const float strength = random.uniform(0, 0.5F);
  const Vec3 tint = mix(grey(1), random_colour(random) * 1.05F, strength);
  material.colour = plain_texture(chance(random, 0.55) ? grey(1) : tint);
  const bool rough = chance(random, 0.35);
  material.kind = rough ? MaterialKind::rough_dielectric : MaterialKind::smooth_dielectric;
  material.roughness = rough ? random.uniform(0.15F, 0.6F) : 0;
  return material;
}

/// Anything but mixed.
Material any_material(SceneBuilder& builder, float size, bool closed) {
  RandomStream& random = builder.random;
  const float kind = random.uniform();
  if (kind < 0.38F) return diffuse(any_texture(builder, size));
  if (kind < 0.62F) return plastic(any_texture(builder, size), size, random);
  if (kind < 0.84F || !closed) return metal(builder, size);
  return glass(random);
}

Material wood(RandomStream& random, float size) {
  const Vec3 colour = near(random, kWoods, 0.3F);
  const Basis turn = random_rotation(random);
  const float darker = random.uniform(0.35F, 0.75F), frequency = log_uniform(random, 4, 14) / size;
  const Texture grain = between(Pattern::wood, colour, colour * darker, turn, frequency, random);
  if (chance(random, 0.2))
    return plastic(plain_texture(near(random, kPaints, 0.2F)), size, random);  // painted
  return chance(random, 0.6) ? plastic(grain, size, random) : diffuse(grain);
}

Material cloth(SceneBuilder& builder, float size) {
  RandomStream& random = builder.random;
  constexpr Pattern kPatterns[] = {Pattern::weave, Pattern::weave, Pattern::stripes, Pattern::checker,
                                   Pattern::plain, Pattern::noise, Pattern::dots};
  if (builder.assets->has_textures() && builder.from_assets()) return diffuse(any_texture(builder, size));
  const Pattern pattern = kPatterns[random.below(7)];
  const Vec3 a = random_colour(random);
  const Vec3 b = chance(random, 0.5) ? random_colour(random) : a * random.uniform(0.4F, 0.8F);
  const float fine = pattern == Pattern::weave ? 40.0F : 10.0F;
  const Basis turn = random_rotation(random);
  const float frequency = log_uniform(random, 0.3F * fine, fine) / size;
  return diffuse(between(pattern, a, b, turn, frequency, random));
}

Material leaf(SceneBuilder& builder, float size) {
  RandomStream& random = builder.random;
  const bool blossom = chance(random, 0.12);
  const Vec3 a = blossom ? random_colour(random) : near(random, kLeaves, 0.4F);
  const Vec3 b = a * random.uniform(0.5F, 0.9F);
  const Basis turn = random_rotation(random);
  const float frequency = log_uniform(random, 4, 20) / size;
  const Texture colour = between(Pattern::noise, a, b, turn, frequency, random);
  Material material = chance(random, 0.4) ? plastic(colour, size, random) : diffuse(colour);
  if (chance(random, 0.2)) {  // eaten by caterpillars
    const float holes = log_uniform(random, 12, 40) / size;
    material.opacity = between(Pattern::dots, grey(1), grey(0), random_rotation(random), holes, random);
  }
  return material;
}

Material stone(RandomStream& random, float size) {
  constexpr Pattern kPatterns[] = {Pattern::noise,  Pattern::noise,   Pattern::marble,
                                   Pattern::cracks, Pattern::voronoi, Pattern::plain};
  const Pattern pattern = kPatterns[random.below(6)];
  const Vec3 a = near(random, kStones, 0.25F);
  const Vec3 b = a * random.uniform(0.3F, 0.8F);
  const Basis turn = random_rotation(random);
  const float frequency = log_uniform(random, 2, 12) / size;
  const Texture colour = between(pattern, a, b, turn, frequency, random);
  return chance(random, 0.3) ? plastic(colour, size, random) : diffuse(colour);
}

Material paper(SceneBuilder& builder, float size) {
  RandomStream& random = builder.random;
  if (chance(random, 0.4)) return diffuse(plain_texture(near(random, kPaints, 0.2F)));
  const Vec3 ink = chance(random, 0.6) ? grey(0.06F) : random_colour(random) * 0.4F;
  const Vec3 sheet = near(random, kPaints, 0.15F);
  const float frequency = log_uniform(random, 8, 50) / size;
  const Basis upright = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  return diffuse(between(Pattern::glyphs, sheet, ink, upright, frequency, random));
}

/// Radiance that makes a surface of this area shine with `power` watts.
Vec3 glow(RandomStream& random, float power, float area) {
  constexpr Vec3 kWarm = {1.3F, 0.9F, 0.5F}, kCool = {0.85F, 1, 1.25F};
  return mix(kWarm, kCool, random.uniform()) * (power / (kPi * area));
}

float area_of(const Mesh& mesh) {
  float area = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    area +=
        0.5F * length(cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]));
  return area;
}

/// A picture, or a screen that shines.
Material screen(SceneBuilder& builder, float size, float area) {
  RandomStream& random = builder.random;
  const Texture picture = any_texture(builder, 0.6F * size);
  if (chance(random, 0.65)) return chance(random, 0.5) ? plastic(picture, size, random) : diffuse(picture);
  Material material = diffuse(plain_texture(grey(0.02F)));
  const float strength = random.uniform(0.05F, 0.3F) / area;
  Texture shine = picture;
  shine.colour_a *= strength;
  shine.colour_b *= strength;
  material.emission = shine;
  return material;
}

Material material_for(SceneBuilder& builder, const Part& part, float size) {
  RandomStream& random = builder.random;
  if (part.stuff == Stuff::bulb || part.stuff == Stuff::screen) {
    const float area = area_of(part.mesh);
    if (part.stuff == Stuff::screen) return screen(builder, size, area);
    Material material = diffuse(plain_texture(grey(0.8F)));
    const float power = log_uniform(random, 0.4F, 2.5F);
    if (chance(random, 0.6)) material.emission = plain_texture(glow(random, power, area));
    return material;
  }
  if (chance(random, 0.12)) return any_material(builder, size, part.closed);  // surprises
  switch (part.stuff) {
    case Stuff::wood:
      return wood(random, size);
    case Stuff::metal:
      return chance(random, 0.8) ? metal(builder, size)
                                 : plastic(plain_texture(random_colour(random)), size, random);
    case Stuff::glass:
      return part.closed ? glass(random) : any_material(builder, size, false);
    case Stuff::cloth:
      return cloth(builder, size);
    case Stuff::leaf:
      return leaf(builder, size);
    case Stuff::stone:
      return stone(random, size);
    case Stuff::paper:
      return paper(builder, size);
    case Stuff::ceramic:
      return chance(random, 0.85) ? plastic(any_texture(builder, size), size, random) : metal(builder, size);
    default:
      return any_material(builder, size, part.closed);
  }
}

}  // namespace

int add_material_of(SceneBuilder& builder, const Part& part) {
  RandomStream& random = builder.random;
  const Bounds bounds = bounds_of(part.mesh.positions);
  const float size = std::max(0.02F, 0.4F * length(bounds.high - bounds.low));
  if (part.stuff == Stuff::any && chance(random, 0.08)) {
    Material mixed;
    mixed.kind = MaterialKind::mixed;
    mixed.first = builder.add(any_material(builder, size, part.closed));
    mixed.second = builder.add(any_material(builder, size, part.closed));
    mixed.mask = chance(random, 0.3) ? plain_texture(grey(random.uniform(0.2F, 0.8F)))
                                     : roughness_texture(size, random);
    return builder.add(mixed);
  }
  if (part.stuff == Stuff::any && chance(random, 0.02)) {  // a thing that glows
    Material lamp = diffuse(any_texture(builder, size));
    const float power = random.uniform(0.2F, 1);
    lamp.emission = plain_texture(glow(random, power, area_of(part.mesh)));
    return builder.add(lamp);
  }
  return builder.add(material_for(builder, part, size));
}

int add_wall_material(SceneBuilder& builder, WallKind kind, Vec3 along, Vec3 upwards) {
  RandomStream& random = builder.random;
  const Basis plane = {along, upwards, cross(along, upwards)};
  const bool floor = kind == WallKind::floor || kind == WallKind::ground;
  const bool outside = kind == WallKind::ground;
  const auto shades = [&] {
    if (kind == WallKind::floor)
      return chance(random, 0.5) ? near(random, kWoods, 0.3F) : near(random, kStones, 0.3F);
    if (outside && chance(random, 0.3)) return near(random, kLeaves, 0.3F);
    if (outside) return chance(random, 0.4) ? random_colour(random) : near(random, kStones, 0.35F);
    return chance(random, 0.75) ? near(random, kPaints, 0.18F) : random_colour(random);
  };
  const Vec3 a = shades();
  const float second = random.uniform(0.35F, 0.85F);
  const Vec3 b = chance(random, 0.7) ? a * second : random_colour(random);
  Texture texture;
  const float pick = random.uniform();
  if (builder.assets->has_textures() && builder.from_assets()) {
    texture = image_texture(builder.assets->texture(random), grey(1));
    texture.orientation = plane;
    texture.frequency = log_uniform(random, 0.15F, 1);
  } else if (pick < (kind == WallKind::ceiling ? 0.7F : floor ? 0.1F : 0.45F)) {
    texture = plain_texture(a);
  } else if (pick < 0.55F) {
    texture = between(Pattern::noise, a, b, plane, log_uniform(random, 0.5F, 8), random);
  } else {
    constexpr Pattern kWalls[] = {Pattern::bricks, Pattern::tiles, Pattern::stripes, Pattern::voronoi,
                                  Pattern::marble, Pattern::dots,  Pattern::wood};
    constexpr Pattern kFloors[] = {Pattern::bricks, Pattern::tiles,   Pattern::checker, Pattern::marble,
                                   Pattern::cracks, Pattern::voronoi, Pattern::weave};
    const uint32_t which = random.below(7);
    const Pattern pattern = floor ? kFloors[which] : kWalls[which];
    texture = between(pattern, a, b, plane, log_uniform(random, 1, outside ? 3.0F : 8.0F), random);
  }
  Material material = diffuse(texture);
  const float finish = random.uniform();
  if (floor && finish < 0.4F) {
    material = plastic(texture, 2, random);
  } else if (!floor && finish < 0.12F) {
    material = plastic(texture, 2, random);
  } else if (finish > 0.95F && kind != WallKind::ceiling) {
    material.kind = MaterialKind::rough_conductor;
    material.roughness = random.uniform(0.35F, 0.7F);
  }
  return builder.add(material);
}

}  // namespace ld
