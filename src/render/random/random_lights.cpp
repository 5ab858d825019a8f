#include "render/random/random_lights.h"

#include "render/geometry/noise.h"
#include "render/random/model_materials.h"
#include "render/random/random_materials.h"

namespace ld {
namespace {

Vec3 towards(float elevation, float azimuth) {
  return {std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
          std::cos(elevation) * std::sin(azimuth)};
}

/// A disk in the sky that lights a surface facing it with `irradiance`.
SkyPatch disk(Vec3 direction, float radius, Vec3 irradiance) {
  const float cos_radius = std::cos(radius);
  return {direction, cos_radius, irradiance / (kPi * (1 - cos_radius * cos_radius))};
}

struct Weather {
  Sky sky;
  Vec3 sun;             // direction
  bool shines = false;  // through the clouds or beside them
};

Weather random_weather(RandomStream& random, bool studio) {
  Weather weather;
  Sky& sky = weather.sky;
  sky.falloff = random.uniform(0.35F, 0.8F);
  const float height = random.uniform(), turn = random.uniform(0, 2 * kPi);
  const uint32_t kind = studio && chance(random, 0.7) ? 4 : random.below(6);
  switch (kind) {
    case 0:  // clear day, the sun from sharp to hazy
    case 1:
      sky.zenith = {0.16F, 0.32F, 0.75F};
      sky.horizon = {0.65F, 0.8F, 1.0F};
      weather.sun = towards(0.4F + 1.0F * height, turn);
      weather.shines = true;
      sky.patches.push_back(disk(weather.sun, log_uniform(random, 0.012F, 0.1F), Vec3{6.5F, 5.8F, 4.8F}));
      break;
    case 2:  // low sun
      sky.zenith = {0.12F, 0.2F, 0.45F};
      sky.horizon = {1.1F, 0.65F, 0.35F};
      weather.sun = towards(0.12F + 0.35F * height, turn);
      weather.shines = true;
      sky.patches.push_back(disk(weather.sun, log_uniform(random, 0.02F, 0.08F), Vec3{6, 3.6F, 1.7F}));
      break;
    case 3:  // overcast (CIE: the zenith three times as bright as the horizon)
      sky.zenith = {1.5F, 1.55F, 1.65F};
      sky.horizon = {0.5F, 0.52F, 0.55F};
      break;
    case 4: {  // a dim dome and soft boxes
      sky.zenith = random_colour(random) * 0.15F;
      sky.horizon = random_colour(random) * 0.4F;
      const uint32_t count = 1 + random.below(4);
      for (uint32_t i = 0; i < count; ++i) {
        const float elevation = random.uniform(0.35F, 1.3F), azimuth = random.uniform(0, 2 * kPi);
        const Vec3 tint = light_colour(random);
        const float strength = random.uniform(0.7F, 2);
        sky.patches.push_back(
            disk(towards(elevation, azimuth), random.uniform(0.1F, 0.35F), tint * strength));
      }
      break;
    }
    default: {  // after sunset: a bright band where the sun went
      sky.zenith = {0.08F, 0.13F, 0.35F};
      sky.horizon = {0.35F, 0.25F, 0.35F};
      sky.patches.push_back(disk(towards(random.uniform(0.1F, 0.4F), turn), 0.9F, Vec3{3, 1.5F, 0.6F}));
      break;
    }
  }
  sky.ground = sky.horizon * 0.35F;
  return weather;
}

/// The sky as a picture, with a layer of clouds lit by the sun.
std::shared_ptr<const TextureImage> cloudy_picture(const Weather& weather, RandomStream& random) {
  constexpr int kWidth = 384, kHeight = 192;
  const float cover = random.uniform(-0.3F, 0.15F), scale = log_uniform(random, 0.5F, 2.5F);
  const uint32_t seed = random.bits();
  auto picture = std::make_shared<TextureImage>();
  picture->width = kWidth;
  picture->height = kHeight;
  for (int j = 0; j < kHeight; ++j)
    for (int i = 0; i < kWidth; ++i) {
      const float polar = kPi * (static_cast<float>(j) + 0.5F) / kHeight;
      const float azimuth = 2 * kPi * ((static_cast<float>(i) + 0.5F) / kWidth - 0.5F);
      // The middle column looks to -z, columns to the right to +x (Probe).
      const Vec3 d = {std::sin(polar) * std::sin(azimuth), std::cos(polar),
                      -std::sin(polar) * std::cos(azimuth)};
      Vec3 colour = weather.sky.gradient(d.y);
      Vec3 disks;
      for (const SkyPatch& patch : weather.sky.patches) {
        // Texels on the rim of a small sun hold a part of it; its whole light must not depend on where it is.
        const float radius = std::max(std::acos(patch.cos_radius), kPi / kHeight);
        const float keep = (1 - patch.cos_radius) / (1 - std::cos(radius));
        if (dot(d, patch.direction) > std::cos(radius)) disks += patch.radiance * keep;
      }
      if (d.y > 0) {
        const Vec3 on_layer = d * (scale / (d.y + 0.12F));
        const float density = std::clamp(2.2F * (fractal_noise(on_layer, 5, seed) + cover), 0.0F, 1.0F) *
                              std::min(1.0F, 6 * d.y);
        const float lit = weather.shines ? 0.6F + 0.4F * std::max(0.0F, dot(d, weather.sun)) : 0.5F;
        const float thick = 1 - 0.55F * density;
        colour = mix(colour, (weather.sky.horizon * 0.5F + grey(0.7F)) * (lit * thick), density);
        disks *= 1 - 0.9F * density;
      }
      picture->texels.push_back(colour + disks);
    }
  return picture;
}

}  // namespace

Vec3 light_colour(RandomStream& random) {
  constexpr Vec3 kWarm = {1.25F, 0.95F, 0.6F}, kCool = {0.85F, 1.0F, 1.25F};
  return mix(kWarm, kCool, random.uniform());
}

void add_environment(SceneBuilder& builder, bool studio) {
  RandomStream& random = builder.random;
  const float turn = random.uniform(0, 2 * kPi);
  const Basis around = turned_about({0, 1, 0}, turn);
  if (builder.assets->has_probes() && builder.from_assets()) {
    builder.scene.probe = Probe{builder.assets->probe(random), around, {1, 1, 1}};
    return;
  }
  const Weather weather = random_weather(random, studio);
  if (!studio && chance(random, 0.45))
    builder.scene.probe = Probe{cloudy_picture(weather, random), {}, {1, 1, 1}};
  else
    builder.scene.sky = weather.sky;
}

void add_area_light(SceneBuilder& builder, Vec3 centre, Vec3 direction, float width, float depth, float power,
                    bool back) {
  const Basis around = basis_around(direction);
  const Vec3 u = around.x * width, v = around.y * depth;
  const Vec3 colour = light_colour(builder.random);
  builder.scene.lights.push_back({centre - 0.5F * (u + v), u, v, colour * (power / (width * depth))});
  if (!back) return;
  // The back is an ordinary surface, lifted off the lamp by a centimetre.
  const Vec3 behind = direction * -0.01F;
  const int housing = add_wall_material(builder, WallKind::wall, around.x, around.y);
  builder.add(make_parallelogram(centre - 0.5F * (u + v) + behind, v, u), housing);
}

void add_point_light(SceneBuilder& builder, Vec3 position, Vec3 direction, float power) {
  RandomStream& random = builder.random;
  PointLight light;
  light.position = position;
  light.intensity = light_colour(random) * power;
  if (chance(random, 0.5)) {
    light.direction = direction;
    const float outer = random.uniform(0.4F, 1);
    light.cos_outer = std::cos(outer);
    light.cos_inner = std::cos(outer * random.uniform(0.3F, 0.9F));
  }
  builder.scene.point_lights.push_back(light);
}

}  // namespace ld
