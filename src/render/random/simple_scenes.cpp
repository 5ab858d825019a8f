#include "render/random/simple_scenes.h"

#include <cmath>

#include "render/geometry/noise.h"
#include "render/geometry/sampling.h"
#include "render/random/random_lights.h"
#include "render/random/random_materials.h"
#include "render/random/random_objects.h"

namespace ld {
namespace {

int add_material(Scene& scene, const Material& material) {
  scene.materials.push_back(material);
  return static_cast<int>(scene.materials.size()) - 1;
}

void add_room(Scene& scene, Vec3 half, float height, RandomStream& random) {
  struct Wall {
    Vec3 corner, edge_u, edge_v;  // facing inwards
  };
  const float x = half.x, z = half.z, h = height;
  const Wall walls[] = {
      {{-x, 0, -z}, {0, 0, 2 * z}, {2 * x, 0, 0}}, {{-x, h, -z}, {2 * x, 0, 0}, {0, 0, 2 * z}},
      {{-x, 0, -z}, {2 * x, 0, 0}, {0, h, 0}},     {{x, 0, z}, {-2 * x, 0, 0}, {0, h, 0}},
      {{-x, 0, z}, {0, 0, -2 * z}, {0, h, 0}},     {{x, 0, -z}, {0, 0, 2 * z}, {0, h, 0}}};
  // Floor and ceiling have their own finish; the walls share one or differ.
  const int shared = add_material(scene, random_wall_material(random, 1.5F));
  const bool all_alike = chance(random, 0.4);
  for (size_t i = 0; i < 6; ++i) {
    const bool own = i < 2 || (!all_alike && chance(random, 0.6));
    const int material = own ? add_material(scene, random_wall_material(random, 1.5F)) : shared;
    scene.objects.push_back(
        {make_parallelogram(walls[i].corner, walls[i].edge_u, walls[i].edge_v), material, {}});
  }
}

/// Small lamps under the ceiling or free in the upper half of the room, tilted at will.
void add_lamps(Scene& scene, Vec3 half, float height, RandomStream& random) {
  const uint32_t count = 1 + random.below(4);
  for (uint32_t i = 0; i < count; ++i) {
    const float width = log_uniform(random, 0.3F, 1.2F), depth = log_uniform(random, 0.3F, 1.2F);
    const bool hangs = chance(random, 0.6);
    const Basis tilt = random_rotation(random);
    // Facing down, cross(u, v) = -y, before it is tilted.
    Vec3 u = {width, 0, 0}, v = {0, 0, depth};
    const float x = random.uniform(-1, 1), y = random.uniform(), z = random.uniform(-1, 1);
    Vec3 centre = {0.8F * x * (half.x - width), height - 0.02F, 0.8F * z * (half.z - depth)};
    if (!hangs) {
      const Vec3 down = normalize(Vec3{0, -1, 0} + 0.8F * tilt.z);
      const Basis around = basis_around(down);
      u = around.x * width;
      v = around.y * depth;
      centre.y = height * (0.55F + 0.35F * y);
      centre.x *= 0.85F;
      centre.z *= 0.85F;
    }
    if (dot(cross(u, v), {0, -1, 0}) < 0) std::swap(u, v);
    const float power = random.uniform(0.4F, 1);
    scene.lights.push_back({centre - 0.5F * (u + v), u, v, light_colour(random) * (power / (width * depth))});
    if (hangs) continue;
    // The back of a free lamp is an ordinary surface, lifted off the lamp by a centimetre.
    const Vec3 behind = normalize(cross(u, v)) * -0.01F;
    const int housing = add_material(scene, random_wall_material(random, 1));
    scene.objects.push_back({make_parallelogram(centre - 0.5F * (u + v) + behind, v, u), housing, {}});
  }
}

}  // namespace

size_t build_simple_room(Scene& scene, int objects, RandomStream& random) {
  const Vec3 half = {random.uniform(2.3F, 4.2F), 0, random.uniform(2.3F, 4.2F)};
  const float height = random.uniform(2.6F, 4.2F);
  add_room(scene, half, height, random);
  add_lamps(scene, half, height, random);
  Camera& camera = scene.camera;
  // Along a wall or in a corner, looking across the room.
  const float angle = random.uniform(0, 2 * kPi);
  camera.position = {0.86F * half.x * std::cos(angle), height * random.uniform(0.25F, 0.75F),
                     0.86F * half.z * std::sin(angle)};
  const float tx = random.uniform(-0.35F, 0.35F), ty = random.uniform(0.15F, 0.45F),
              tz = random.uniform(-0.35F, 0.35F);
  camera.axes = look_at(camera.position, {tx * half.x, ty * height, tz * half.z}, {0, 1, 0},
                        random.uniform(-0.06F, 0.06F));
  camera.fov = random.uniform(0.75F, 1.2F);
  Stage stage;
  stage.low = {-half.x, 0, -half.z};
  stage.high = {half.x, 0.9F * height, half.z};
  stage.floor = [](float, float) { return 0.0F; };
  stage.camera = camera.position;
  stage.clear = 0.7F;
  stage.smallest = 0.15F;
  stage.largest = 0.75F;
  stage.floating = 0.35;
  const size_t first_object = scene.objects.size();
  add_random_objects(scene, stage, objects, random);
  return first_object;
}

namespace {

void add_sky(Scene& scene, RandomStream& random) {
  Sky sky;
  sky.falloff = random.uniform(0.35F, 0.8F);
  const uint32_t weather = random.below(4);
  const float height = random.uniform(), turn = random.uniform(0, 2 * kPi);
  const auto towards = [](float elevation, float azimuth) {
    return Vec3{std::cos(elevation) * std::cos(azimuth), std::sin(elevation),
                std::cos(elevation) * std::sin(azimuth)};
  };
  // A patch that lights a surface facing it with `irradiance`.
  const auto add_patch = [&](Vec3 direction, float radius, Vec3 irradiance) {
    const float cos_radius = std::cos(radius);
    sky.patches.push_back({direction, cos_radius, irradiance / (kPi * (1 - cos_radius * cos_radius))});
  };
  switch (weather) {
    case 0:  // clear day, the sun from sharp to hazy
      sky.zenith = {0.16F, 0.32F, 0.75F};
      sky.horizon = {0.65F, 0.8F, 1.0F};
      add_patch(towards(0.4F + 1.0F * height, turn), log_uniform(random, 0.012F, 0.1F),
                Vec3{4.2F, 3.8F, 3.2F});
      break;
    case 1:  // low sun
      sky.zenith = {0.12F, 0.2F, 0.45F};
      sky.horizon = {1.1F, 0.65F, 0.35F};
      add_patch(towards(0.12F + 0.35F * height, turn), log_uniform(random, 0.02F, 0.08F),
                Vec3{4.5F, 2.6F, 1.2F});
      break;
    case 2:  // overcast (CIE: the zenith three times as bright as the horizon)
      sky.zenith = {1.5F, 1.55F, 1.65F};
      sky.horizon = {0.5F, 0.52F, 0.55F};
      break;
    default: {  // a dim dome and soft boxes
      sky.zenith = random_colour(random) * 0.15F;
      sky.horizon = random_colour(random) * 0.4F;
      const uint32_t count = 1 + random.below(3);
      for (uint32_t i = 0; i < count; ++i) {
        const float elevation = random.uniform(0.35F, 1.3F), azimuth = random.uniform(0, 2 * kPi);
        const Vec3 tint = light_colour(random);
        const Vec3 irradiance = tint * random.uniform(0.7F, 2);
        add_patch(towards(elevation, azimuth), random.uniform(0.1F, 0.3F), irradiance);
      }
      break;
    }
  }
  sky.ground = sky.horizon * 0.35F;
  scene.sky = sky;
}

}  // namespace

size_t build_simple_outdoors(Scene& scene, int objects, RandomStream& random) {
  add_sky(scene, random);
  const bool hilly = chance(random, 0.5);
  const float amplitude = hilly ? random.uniform(0.2F, 0.9F) : 0.0F, frequency = random.uniform(0.12F, 0.3F);
  const uint32_t hills = random.bits();
  const auto floor = [=](float x, float z) {
    return hilly ? amplitude * fractal_noise(Vec3{x, 0, z} * frequency + grey(0.5F), 4, hills) : 0.0F;
  };
  const int ground = add_material(scene, random_wall_material(random, 2));
  scene.objects.push_back({make_ground(40, hilly ? 100 : 1, amplitude, frequency, hills), ground, {}});
  // The plain beyond the hills, out to the horizon.
  Object plain = {make_ground(2000, 1, 0, 1, 0), ground, {}};
  place(plain.mesh, grey(1), {}, {0, -0.4F * amplitude - 0.05F, 0});
  scene.objects.push_back(std::move(plain));

  Camera& camera = scene.camera;
  const float distance = random.uniform(4.5F, 8.5F), angle = random.uniform(0, 2 * kPi);
  camera.position = {distance * std::cos(angle), 0, distance * std::sin(angle)};
  camera.position.y = floor(camera.position.x, camera.position.z) + random.uniform(0.7F, 3.5F);
  const float tx = random.uniform(-1, 1), ty = random.uniform(0.1F, 1), tz = random.uniform(-1, 1);
  camera.axes = look_at(camera.position, {tx, ty, tz}, {0, 1, 0}, random.uniform(-0.06F, 0.06F));
  camera.fov = random.uniform(0.55F, 0.95F);
  Stage stage;
  const float reach = random.uniform(3, 5.5F);
  stage.low = {-reach, 0, -reach};
  stage.high = {reach, 3, reach};
  stage.floor = floor;
  stage.camera = camera.position;
  stage.clear = 1.2F;
  stage.smallest = 0.25F;
  stage.largest = 1.2F;
  stage.floating = 0.2;
  const size_t first_object = scene.objects.size();
  add_random_objects(scene, stage, objects, random);
  return first_object;
}

}  // namespace ld
