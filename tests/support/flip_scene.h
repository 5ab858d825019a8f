// A small scene that can be rendered mirrored or turned about the view axis, with the same camera samples
// mirrored and turned along. What a data augmentation makes of frame(Turn{}) must equal frame(turn) in all 20
// channels: the radiance is that of the lamps alone (no random bounce), the guides know no noise but the
// camera's own. Link ld_render_core.
//
//   const Frame upright = turned_frame({}, 32, 4);
//   const Frame expected = turned_frame({true, false, 1}, 32, 4);  // flip in x, then one turn
//   counterclockwise
//
// Rays that graze a silhouette may differ: compare with differing_samples() against a small share.
#pragma once

#include <cmath>

#include "frame/frame.h"
#include "render/trace/path_tracer.h"

namespace ld {

/// Applied in this order: mirror left to right, mirror top to bottom, quarter turns counterclockwise for the
/// viewer.
struct Turn {
  bool flip_x = false, flip_y = false;
  int quarter_turns = 0;

  /// On view space, +y up.
  Vec3 operator()(Vec3 v) const {
    if (flip_x) v.x = -v.x;
    if (flip_y) v.y = -v.y;
    for (int i = 0; i < quarter_turns; ++i) v = {-v.y, v.x, v.z};
    return v;
  }
  bool mirrors() const { return flip_x != flip_y; }
};

inline void turn_mesh(Mesh& mesh, const Turn& turn) {
  for (Vec3& p : mesh.positions) p = turn(p);
  for (Vec3& n : mesh.normals) n = turn(n);
  if (turn.mirrors())  // keep the triangles counter-clockwise from outside
    for (auto& triangle : mesh.triangles) std::swap(triangle[1], triangle[2]);
}

/// Five materials, a lamp, motion and defocus, none of it symmetric. The camera sits at the origin and looks
/// along -z.
inline Scene flip_scene(const Turn& turn, int size) {
  Scene scene;
  scene.camera.width = scene.camera.height = size;
  scene.camera.fov = 0.9F;
  scene.camera.focus_distance = 4;
  scene.camera.lens_radius = 0.08F;
  scene.camera.shutter = true;

  const auto add = [&](Mesh mesh, Vec3 scale, const Basis& tilt, Vec3 centre, Vec3 motion,
                       const Material& material) {
    place(mesh, scale, tilt, centre);
    turn_mesh(mesh, turn);
    Material turned = material;
    for (Vec3* axis :
         {&turned.colour.orientation.x, &turned.colour.orientation.y, &turned.colour.orientation.z})
      *axis = turn(*axis);
    scene.objects.push_back(
        {mesh, static_cast<int>(scene.materials.size()), turn(motion), turn(motion * -1.5F)});
    scene.materials.push_back(turned);
  };
  const auto material = [](MaterialKind kind, Pattern pattern, Vec3 a, Vec3 b, float roughness) {
    Material result;
    result.kind = kind;
    result.colour.pattern = pattern;
    result.colour.colour_a = a;
    result.colour.colour_b = b;
    result.colour.frequency = 1.3F;
    result.roughness = roughness;
    return result;
  };
  const Basis tilt = look_at({0, 0, 0}, {1, 2, -1}, {0, 1, 0}, 0.4F);
  const Vec3 red = {0.8F, 0.2F, 0.1F}, blue = {0.1F, 0.3F, 0.9F};
  const Basis facing = basis_around(normalize(Vec3{0.2F, 0.3F, 1}));
  add(make_ground(3, 1, 0, 1, 0), grey(1), {facing.y, facing.z, facing.x}, {0.3F, -0.4F, -6}, {},
      material(MaterialKind::diffuse, Pattern::marble, red, blue, 1));
  add(make_sphere(3), grey(0.6F), tilt, {-0.9F, 0.7F, -4}, {0.4F, 0.1F, 0.2F},
      material(MaterialKind::rough_conductor, Pattern::noise, red, grey(0.9F), 0.4F));
  add(make_box(), {0.5F, 0.3F, 0.4F}, tilt, {0.8F, -0.6F, -3}, {-0.1F, 0.3F, 0},
      material(MaterialKind::diffuse, Pattern::stripes, blue, red, 1));
  add(make_torus(0.3F, 24, 12), grey(0.4F), tilt, {0.9F, 0.9F, -5}, {},
      material(MaterialKind::smooth_dielectric, Pattern::plain, grey(0.9F), grey(1), 0));
  add(make_blob(0.3F, 1.5F, 2, 7, 3), grey(0.4F), tilt, {-0.7F, -0.8F, -3.5F}, {0, -0.2F, 0},
      material(MaterialKind::rough_dielectric, Pattern::plain, {0.7F, 1, 0.8F}, grey(1), 0.3F));

  AreaLight lamp = {turn({0, 1.1F, -4}), turn({0.5F, 0.2F, 0}), turn({-0.1F, 0.4F, 0.2F}), {3, 2, 1}};
  if (turn.mirrors()) std::swap(lamp.edge_u, lamp.edge_v);
  scene.lights.push_back(lamp);
  return scene;
}

/// A [size, size] frame of flip_scene: sample s of the pixel that the turn maps pixel p to is sample s of
/// pixel p.
inline Frame turned_frame(const Turn& turn, int size, int spp, uint64_t seed = 1) {
  const PreparedScene scene(flip_scene(turn, size));
  PathSettings only_lamps;
  only_lamps.max_bounces = 0;
  Frame frame(size, size, spp);
  const float half = 0.5F * static_cast<float>(size);
  for (int y = 0; y < size; ++y)
    for (int x = 0; x < size; ++x)
      for (int s = 0; s < spp; ++s) {
        SampleNumbers numbers(RandomStream(seed, RandomPurpose::test, static_cast<uint32_t>(y * size + x),
                                           static_cast<uint32_t>(s)));
        CameraSample where = draw_camera_sample(scene.scene().camera, x, y, numbers);
        const Vec3 place = turn({where.x - half, half - where.y, 0}),
                   lens = turn({where.lens.x, where.lens.y, 0});
        where.x = half + place.x;
        where.y = half - place.y;
        where.lens = {lens.x, lens.y};
        const Vec3 centre =
            turn({static_cast<float>(x) + 0.5F - half, half - static_cast<float>(y) - 0.5F, 0});
        const auto pixel = static_cast<size_t>(std::floor(half - centre.y)) * static_cast<size_t>(size) +
                           static_cast<size_t>(std::floor(half + centre.x));
        const auto values = trace_sample(scene, where, numbers, only_lamps);
        for (int c = 0; c < kSampleChannels; ++c) frame.plane(s, c)[pixel] = values[static_cast<size_t>(c)];
      }
  frame.info.depth_scale = median_depth(frame);
  return frame;
}

/// Samples of which some channel differs by more than tolerance * max(1, |expected|).
inline int64_t differing_samples(const Frame& found, const Frame& expected, float tolerance) {
  if (found.samples.size() != expected.samples.size() || found.width != expected.width)
    return expected.spp * int64_t{expected.width} * expected.height;
  int64_t differing = 0;
  for (int s = 0; s < expected.spp; ++s)
    for (size_t p = 0; p < expected.plane_size(); ++p) {
      bool differs = false;
      for (int c = 0; c < kSampleChannels; ++c) {
        const float a = found.plane(s, c)[p], b = expected.plane(s, c)[p];
        differs = differs || !(std::abs(a - b) <= tolerance * std::max(1.0F, std::abs(b)));
      }
      differing += differs ? 1 : 0;
    }
  return differing;
}

}  // namespace ld
