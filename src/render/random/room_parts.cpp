#include "render/random/room_parts.h"

#include "render/random/model_materials.h"
#include "render/random/random_materials.h"
#include "render/random/shapes/furniture.h"
#include "render/random/shapes/shapes.h"

namespace ld {

std::array<Wall, 6> box_walls(Vec3 half, float height) {
  const float x = half.x, z = half.z, h = height;
  const Vec3 X = {1, 0, 0}, Y = {0, 1, 0}, Z = {0, 0, 1};
  return {{{{-x, 0, -z}, X, Y, 2 * x, h},
           {{x, 0, z}, -X, Y, 2 * x, h},
           {{-x, 0, z}, -Z, Y, 2 * z, h},
           {{x, 0, -z}, Z, Y, 2 * z, h},
           {{-x, 0, -z}, Z, X, 2 * z, 2 * x},
           {{-x, h, -z}, X, Z, 2 * x, 2 * z}}};
}

void add_wall(SceneBuilder& builder, const Wall& wall, const std::vector<Opening>& openings, int material,
              float depth) {
  std::vector<float> lines_s = {0, wall.width}, lines_t = {0, wall.height};
  for (const Opening& hole : openings) {
    lines_s.insert(lines_s.end(), {hole.s0, hole.s1});
    lines_t.insert(lines_t.end(), {hole.t0, hole.t1});
  }
  std::sort(lines_s.begin(), lines_s.end());
  std::sort(lines_t.begin(), lines_t.end());
  const auto is_open = [&](float s, float t) {
    return std::any_of(openings.begin(), openings.end(),
                       [&](const Opening& o) { return s > o.s0 && s < o.s1 && t > o.t0 && t < o.t1; });
  };
  Mesh mesh;
  for (size_t i = 0; i + 1 < lines_s.size(); ++i)
    for (size_t j = 0; j + 1 < lines_t.size(); ++j) {
      const float s0 = lines_s[i], s1 = lines_s[i + 1], t0 = lines_t[j], t1 = lines_t[j + 1];
      if (s1 - s0 < 1e-5F || t1 - t0 < 1e-5F || is_open(0.5F * (s0 + s1), 0.5F * (t0 + t1))) continue;
      append(mesh, make_parallelogram(wall.at(s0, t0), wall.along * (s1 - s0), wall.up * (t1 - t0)));
    }
  const Vec3 out = wall.normal() * -depth;
  for (const Opening& o : openings) {  // the sides of the hole, facing into it
    const Vec3 across = wall.along * (o.s1 - o.s0), upwards = wall.up * (o.t1 - o.t0);
    append(mesh, make_parallelogram(wall.at(o.s0, o.t0), out, across));
    append(mesh, make_parallelogram(wall.at(o.s0, o.t1), across, out));
    append(mesh, make_parallelogram(wall.at(o.s0, o.t0), upwards, out));
    append(mesh, make_parallelogram(wall.at(o.s1, o.t0), out, upwards));
  }
  builder.add(std::move(mesh), material);
}

void add_window_frame(SceneBuilder& builder, const Wall& wall, const Opening& hole, int columns, int rows) {
  constexpr float kBar = 0.025F;
  Mesh frame;
  const Basis axes = {wall.along, wall.up, wall.normal()};
  const float width = hole.s1 - hole.s0, height = hole.t1 - hole.t0;
  for (int i = 0; i <= columns; ++i) {
    const float s = hole.s0 + kBar + (width - 2 * kBar) * share(i, columns);
    append(frame, placed(make_block({}, {kBar, 0.5F * height, 0.03F}), grey(1), axes,
                         wall.at(s, hole.t0 + 0.5F * height, -0.1F)));
  }
  for (int j = 0; j <= rows; ++j) {
    const float t = hole.t0 + kBar + (height - 2 * kBar) * share(j, rows);
    append(frame, placed(make_block({}, {0.5F * width, kBar, 0.028F}), grey(1), axes,
                         wall.at(hole.s0 + 0.5F * width, t, -0.1F)));
  }
  builder.add(std::move(frame),
              add_material_of(builder, {{make_block({}, {0.3F, 0.5F, 0.03F})}, Stuff::wood, true}));
}

void dress_window(SceneBuilder& builder, const Wall& wall, const Opening& hole) {
  RandomStream& random = builder.random;
  const uint32_t kind = random.below(3);
  const float width = hole.s1 - hole.s0, middle = 0.5F * (hole.s0 + hole.s1);
  const Basis axes = {wall.along, wall.up, wall.normal()};
  if (kind == 0) {
    const float low = std::max(0.05F, hole.t0 - random.uniform(0.2F, 1)),
                top = std::min(wall.height - 0.05F, hole.t1 + 0.15F);
    const Part cloth = {make_curtain(random), Stuff::cloth, false};
    const int material = add_material_of(builder, cloth);
    for (const float side : {-1.0F, 1.0F}) {
      const float s = std::clamp(middle + side * 0.5F * width, 0.3F, wall.width - 0.3F);
      builder.add(placed(make_curtain(random), {0.3F, 0.5F * (top - low), 0.8F}, axes,
                         wall.at(s, 0.5F * (top + low), 0.12F)),
                  material);
    }
    builder.add(make_rod(wall.at(std::max(0.05F, hole.s0 - 0.3F), top, 0.12F),
                         wall.at(std::min(wall.width - 0.05F, hole.s1 + 0.3F), top, 0.12F), 0.015F, 8),
                add_material_of(builder, {make_sphere(1), Stuff::metal, true}));
  } else if (kind == 1) {
    const float drop = (hole.t1 - hole.t0) * random.uniform(0.3F, 1), tilt = random.uniform(-0.8F, 0.8F);
    const Mesh blinds = make_blinds(static_cast<int>(drop / 0.05F) + 2, tilt);
    const int material = add_material_of(builder, {make_block({}, grey(0.4F)), Stuff::ceramic, true});
    builder.add(placed(blinds, {0.52F * width, 0.5F * drop, 0.5F}, axes,
                       wall.at(middle, hole.t1 - 0.5F * drop, 0.03F)),
                material);
  }
}

void add_door(SceneBuilder& builder, const Wall& wall, float s) {
  const Basis axes = {wall.along, wall.up, wall.normal()};
  const float width = builder.random.uniform(0.38F, 0.48F), height = std::min(2.05F, 0.92F * wall.height);
  const auto put = [&](Mesh mesh, float at_s, float at_t, float lift) {
    return placed(std::move(mesh), grey(1), axes, wall.at(at_s, at_t, lift));
  };
  Model door;
  add_part(door, Stuff::wood,
           put(make_rounded_box({width, 0.5F * height, 0.02F}, 0.006F), s, 0.5F * height, 0));
  for (const float part : {0.28F, 0.72F})
    add_part(door, Stuff::wood,
             put(make_rounded_box({0.68F * width, 0.17F * height, 0.015F}, 0.01F), s, part * height, 0.012F));
  add_part(door, Stuff::metal,
           put(make_rod({}, {-0.12F, 0, 0}, 0.012F, 8), s + 0.85F * width, 0.48F * height, 0.06F));
  add_part(door, Stuff::metal,
           put(make_rod({}, {0, 0, 0.06F}, 0.01F, 8), s + 0.85F * width, 0.48F * height, 0));
  for (const float side : {-1.0F, 1.0F})
    add_part(door, Stuff::any,
             put(make_block({}, {0.04F, 0.5F * height + 0.04F, 0.03F}), s + side * (width + 0.04F),
                 0.5F * height + 0.04F, 0));
  builder.add(door, true);
}

Opening random_window(SceneBuilder& builder, const Wall& wall, float sill) {
  RandomStream& random = builder.random;
  const float width = std::min(random.uniform(0.8F, 2.2F), 0.7F * wall.width);
  const float s = 0.1F + random.uniform() * (wall.width - width - 0.2F);
  const float top = wall.height - random.uniform(0.2F, 0.5F);
  const Opening hole = {s, std::min(sill, top - 0.5F), s + width, top};
  const int columns = 1 + static_cast<int>(random.below(4)), rows = 1 + static_cast<int>(random.below(3));
  add_window_frame(builder, wall, hole, columns, rows);
  return hole;
}

void set_against(SceneBuilder& builder, const Wall& wall, float s, Model model, float gap) {
  const Bounds bounds = bounds_of(model);
  const float half = 0.5F * (bounds.high.x - bounds.low.x);
  const float at = half < 0.5F * wall.width ? std::clamp(s, half, wall.width - half) : 0.5F * wall.width;
  const Vec3 foot = wall.at(at, 0, gap - bounds.low.z);
  builder.furnish(std::move(model), {foot.x, foot.y - bounds.low.y, foot.z}, wall.turn());
}

void hang(SceneBuilder& builder, const Wall& wall, float s, float t, Model model) {
  const Bounds bounds = bounds_of(model);
  const Vec3 at = wall.at(s, t, 0.01F - bounds.low.z);
  builder.furnish(std::move(model), at - Vec3{0, bounds.centre().y, 0}, wall.turn());
}

void make_spot(SceneBuilder& builder, float smallest, float largest) {
  const Bounds box = builder.placed.back().bounds;
  make_spot(builder, {box.low.x, box.high.y, box.low.z}, {box.high.x, box.high.y, box.high.z}, smallest,
            largest);
}

void make_spot(SceneBuilder& builder, Vec3 low, Vec3 high, float smallest, float largest) {
  const Vec3 inset = (high - low) * 0.12F;
  builder.spots.push_back({low + inset, high - inset, smallest, largest});
}

void place_camera(SceneBuilder& builder, const Bounds& region, float nearest, float fov_low, float fov_high) {
  RandomStream& random = builder.random;
  Camera& camera = builder.scene.camera;
  const Vec3 size = region.high - region.low;
  camera.fov = random.uniform(fov_low, fov_high);
  constexpr int kTries = 80;  // then the last one has to do; the draft will be looked at
  for (int t = 0; t < kTries; ++t) {
    const float u = random.uniform(), v = random.uniform(), w = random.uniform();
    camera.position = region.low + Vec3{u, v, w} * size;
    const float a = random.uniform(0.15F, 0.85F), b = random.uniform(0, 0.7F),
                c = random.uniform(0.15F, 0.85F);
    const Vec3 target = region.low + Vec3{a, b, c} * size - Vec3{0, 0.3F * size.y, 0};
    const float roll = random.uniform(-0.06F, 0.06F);
    const Vec3 way = target - camera.position;
    if (length(Vec3{way.x, 0, way.z}) < nearest || std::abs(way.y) > 0.7F * length(way)) continue;
    camera.axes = look_at(camera.position, target, {0, 1, 0}, roll);
    // Neither in something nor right before it.
    if (builder.occupancy.distance(camera.position) < 0.35F) continue;
    if (builder.occupancy.distance(camera.position + normalize(way) * 0.8F) < 0.2F) continue;
    break;
  }
}

void scale_environment(Scene& scene, float factor) {
  if (scene.probe) scene.probe->scale *= factor;
  if (!scene.sky) return;
  scene.sky->zenith *= factor;
  scene.sky->horizon *= factor;
  scene.sky->ground *= factor;
  for (SkyPatch& patch : scene.sky->patches) patch.radiance *= factor;
}

void set_floor_spot(SceneBuilder& builder, Vec3 half, float height, float largest) {
  builder.spots = {{{-half.x, 0, -half.z}, {half.x, 0, half.z}, 0.18F, largest}};
  builder.ceiling = 0.9F * height;
}

}  // namespace ld
