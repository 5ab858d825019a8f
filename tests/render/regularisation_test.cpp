// Path regularisation and the clamp of indirect light.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>

#include "tests/render/test_scenes.h"

namespace ld {
namespace {

/// A white floor and a white ball of this material above it.
Scene floor_and_ball(MaterialKind ball) {
  Scene scene;
  scene.name = "floor and ball";
  scene.objects.push_back({make_parallelogram({-4, 0, 4}, {8, 0, 0}, {0, 0, -8}), 0, {}});
  Mesh sphere = make_sphere(4);
  place(sphere, grey(0.7F), look_at({}, {0, 0, 1}, {0, 1, 0}), {0, 0.8F, 0});
  scene.objects.push_back({sphere, 1, {}});
  scene.materials = {plain_material(MaterialKind::diffuse, grey(1)),
                     plain_material(ball, grey(1), ball == MaterialKind::plastic ? 0.0F : 0.1F)};
  // The floor beside the ball, and nothing but the floor.
  scene.camera = simple_camera({3, 2, 0}, {1.2F, 0, 0}, 0.1F, 8);
  return scene;
}

Scene under_sky(MaterialKind ball) {
  Scene scene = floor_and_ball(ball);
  scene.sky = constant_sky(1);
  return scene;
}

Scene under_lamp(MaterialKind ball) {
  Scene scene = floor_and_ball(ball);
  scene.lights.push_back({{2, 3, -0.5F}, {1, 0, 0}, {0, 0, 1}, grey(5)});
  return scene;
}

PathSettings regularised(float roughness, LightStrategy strategy = LightStrategy::mis) {
  PathSettings settings;
  settings.regularisation = roughness;
  settings.strategy = strategy;
  return settings;
}

Vec3 one_path(const PreparedScene& scene, const PathSettings& settings, uint32_t number) {
  SampleNumbers numbers(RandomStream(3, RandomPurpose::test, number));
  const CameraSample where = draw_camera_sample(scene.scene().camera, static_cast<int>(number % 8),
                                                static_cast<int>(number / 8 % 8), numbers);
  return trace_path(scene, scene.scene().camera.ray(where), where.time, numbers, settings);
}

TEST(Regularisation, WhiteFurnaceHolds) {
  for (const MaterialKind kind : {MaterialKind::mirror, MaterialKind::smooth_dielectric,
                                  MaterialKind::plastic, MaterialKind::rough_conductor}) {
    SCOPED_TRACE(static_cast<int>(kind));
    PathSettings settings = regularised(0.3F);
    settings.max_bounces = 60;
    const Estimate found = mean_luminance(PreparedScene(under_sky(kind)), settings, 100, 1);
    EXPECT_LT(found.mean, 1 + 4 * found.error + 0.001);
    // What the ball sends to the floor, a part of all light, lacks what a single scattering loses.
    EXPECT_GT(found.mean, 0.985);
    EXPECT_LT(found.error, 0.004);
  }
}

TEST(Regularisation, AllStrategiesSeeTheSameSurface) {
  for (const MaterialKind kind : {MaterialKind::mirror, MaterialKind::plastic}) {
    SCOPED_TRACE(static_cast<int>(kind));
    const PreparedScene scene(under_lamp(kind));
    const Estimate mis = mean_luminance(scene, regularised(0.5F), 300, 4);
    const Estimate lights = mean_luminance(scene, regularised(0.5F, LightStrategy::light_sampling), 300, 5);
    const Estimate bsdf = mean_luminance(scene, regularised(0.5F, LightStrategy::bsdf_sampling), 600, 6);
    EXPECT_LT(z_score(mis, lights), 4) << mis.mean << " and " << lights.mean;
    EXPECT_LT(z_score(mis, bsdf), 4) << mis.mean << " and " << bsdf.mean;
  }
  const PreparedScene scene(under_lamp(MaterialKind::mirror));
  const Estimate all = mean_luminance(scene, {}, 1000, 7);
  // The blur moves light about but adds and takes little.
  const Estimate blurred = mean_luminance(scene, regularised(0.3F), 300, 9);
  EXPECT_NEAR(blurred.mean / all.mean, 1, 0.05);
  EXPECT_LT(blurred.error * std::sqrt(300.0), 0.7 * all.error * std::sqrt(1000.0)) << "less noise a sample";
}

TEST(Regularisation, LeavesDiffuseScenesAndFirstSightAsTheyAre) {
  const PreparedScene diffuse(under_lamp(MaterialKind::diffuse));
  Scene looking = under_lamp(MaterialKind::mirror);
  looking.camera = simple_camera({3, 2, 0}, {0, 0.8F, 0}, 0.05F, 8);  // into the mirror
  const PreparedScene mirror(looking);
  PathSettings direct = regularised(0.5F), plain;
  direct.max_bounces = plain.max_bounces = 2;  // mirror, floor, lamp: nothing after a diffuse surface
  for (uint32_t i = 0; i < 200; ++i) {
    const Vec3 with = one_path(diffuse, regularised(0.5F), i), without = one_path(diffuse, {}, i);
    EXPECT_EQ(with.x, without.x);
    EXPECT_EQ(one_path(mirror, direct, i).x, one_path(mirror, plain, i).x);
  }
}

TEST(Regularisation, RaisesRoughnessAndLeavesWhatDoesNotBend) {
  Bsdf thin;
  thin.kind = MaterialKind::smooth_dielectric;
  thin.eta = 1.005F;
  thin.regularise(0.1F);
  EXPECT_TRUE(thin.is_delta());
  Bsdf rough;
  rough.kind = MaterialKind::rough_conductor;
  rough.alpha = 0.4F;
  rough.regularise(0.1F);
  EXPECT_EQ(rough.alpha, 0.4F);
  Bsdf coated;
  coated.kind = MaterialKind::coated_metal;
  coated.alpha = 0;
  coated.base_alpha = 0.01F;
  coated.regularise(0.1F);
  EXPECT_EQ(coated.alpha, 0.1F);
  EXPECT_EQ(coated.base_alpha, 0.1F);
  // The least roughness there is gives finite paths, too.
  const PreparedScene scene(under_lamp(MaterialKind::mirror));
  for (uint32_t i = 0; i < 200; ++i) EXPECT_TRUE(std::isfinite(one_path(scene, regularised(1e-20F), i).x));
  EXPECT_TRUE(std::isfinite(one_path(scene, regularised(1), 0).x));
}

TEST(IndirectClamp, KeepsTheHueAndNeverRaises) {
  for (const Vec3 value : {Vec3{0, 0, 0}, Vec3{1, 2, 4}, Vec3{3e38F, 1e38F, 0}, Vec3{1e-38F, 1e-40F, 1e-45F},
                           Vec3{65504, 1e-3F, 7}, Vec3{0.1F, 0.7F, 0.70001F}})
    for (const float bound : {1e-40F, 1e-3F, 0.7F, 4.0F, 65504.0F, 1e30F}) {
      SCOPED_TRACE(fmt::format("{} {} {} to {}", value.x, value.y, value.z, bound));
      const Vec3 clamped = clamp_contribution(value, bound);
      EXPECT_LE(max_component(clamped), bound);
      for (int c = 0; c < 3; ++c) EXPECT_LE(clamped[c], value[c]);
      if (max_component(value) <= bound) {
        EXPECT_EQ(clamped.x, value.x);
      } else if (bound >= 1e-3F) {
        EXPECT_FLOAT_EQ(max_component(clamped), bound);
        const double scale = double{bound} / max_component(value);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(clamped[c], value[c] * scale, 1e-6 * bound);
      }
    }
  EXPECT_EQ(clamp_contribution({5, 1, 2}, 0).x, 5);
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  EXPECT_EQ(clamp_contribution({kInfinity, 1, 2}, 1).x, kInfinity) << "a fault stays visible";
  EXPECT_TRUE(std::isnan(clamp_contribution({std::nanf(""), 1, 2}, 1).x));
}

TEST(IndirectClamp, BoundsWhatCameOverTwoBouncesOnly) {
  const PreparedScene scene(under_lamp(MaterialKind::mirror));
  PathSettings tight, loose, direct, tight_direct;
  tight.indirect_clamp = tight_direct.indirect_clamp = 1e-3F;
  loose.indirect_clamp = 1e30F;
  direct.max_bounces = tight_direct.max_bounces = 1;
  int lower = 0;
  for (uint32_t i = 0; i < 500; ++i) {
    const Vec3 plain = one_path(scene, {}, i), bounded = one_path(scene, tight, i);
    EXPECT_EQ(one_path(scene, loose, i).x, plain.x);
    EXPECT_LE(bounded.x, plain.x);
    lower += bounded.x < plain.x ? 1 : 0;
    const Vec3 lit = one_path(scene, direct, i);
    EXPECT_EQ(one_path(scene, tight_direct, i).x, lit.x);
    // Four more vertices of at most two contributions each.
    EXPECT_LE(bounded.x, lit.x + 8.1e-3F);
  }
  EXPECT_GT(lower, 20);

  // A lamp in a mirror, and what a mirror shows lit by it, is not indirect.
  Scene looking = under_lamp(MaterialKind::mirror);
  looking.camera = simple_camera({3, 2, 0}, {0, 0.8F, 0}, 0.4F, 8);
  const PreparedScene mirror(looking);
  tight.max_bounces = loose.max_bounces = 2;
  for (uint32_t i = 0; i < 64; ++i) {
    CameraSample middle;
    const uint32_t column = i % 8, row = i / 8;
    middle.x = static_cast<float>(column) + 0.5F;
    middle.y = static_cast<float>(row) + 0.5F;
    const Ray ray = mirror.scene().camera.ray(middle);
    const auto first = mirror.trace(ray, 0);
    if (!first || first->object != 1) continue;
    SampleNumbers a(RandomStream(4, RandomPurpose::test, i)), b = a;
    EXPECT_EQ(trace_path(mirror, ray, 0, a, tight).x, trace_path(mirror, ray, 0, b, loose).x);
  }
}

}  // namespace
}  // namespace ld
