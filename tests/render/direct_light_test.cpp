// Direct light against the closed form, the strategies against each other, and the absence of bias.
#include <gtest/gtest.h>

#include <vector>

#include "render/trace/image_renderer.h"
#include "tests/render/test_scenes.h"

namespace ld {
namespace {

/// Irradiance at `point` with normal `n` from a polygon of radiance 1, its corners counter-clockwise as seen
/// from the point (Lambert 1760): half the sum over the edges of the angle they subtend times the edge
/// plane's normal along n.
double lambert_irradiance(const std::vector<Vec3>& corners, Vec3 point, Vec3 n) {
  double sum = 0;
  for (size_t i = 0; i < corners.size(); ++i) {
    const Vec3 a = normalize(corners[i] - point), b = normalize(corners[(i + 1) % corners.size()] - point);
    sum += std::acos(std::clamp(static_cast<double>(dot(a, b)), -1.0, 1.0)) * dot(normalize(cross(a, b)), n);
  }
  return std::abs(sum) / 2;
}

TEST(DirectLight, SquareLampMatchesLambert) {
  Scene scene;
  scene.objects.push_back({make_ground(10, 1, 0, 1, 0), 0, {}});
  scene.materials.push_back(plain_material(MaterialKind::diffuse, {0.5F, 0.5F, 0.5F}));
  const AreaLight lamp = {{-0.5F, 2, -0.5F}, {1, 0, 0}, {0, 0, 1}, {10, 10, 10}};  // faces down
  scene.lights.push_back(lamp);
  PathSettings settings;
  settings.max_bounces = 1;
  const std::vector<Vec3> corners = {{-0.5F, 2, -0.5F}, {0.5F, 2, -0.5F}, {0.5F, 2, 0.5F}, {-0.5F, 2, 0.5F}};
  for (const Vec3 target : {Vec3{0, 0, 0}, Vec3{1, 0, 0.5F}, Vec3{-2.5F, 0, 1}}) {
    SCOPED_TRACE(target.x);
    // A pencil of rays onto the spot, from beside the lamp.
    scene.camera = simple_camera(target + Vec3{20, 15, 3}, target, 1e-4F, 4);
    const double expected = 0.5 / kPi * 10 * lambert_irradiance(corners, target, {0, 1, 0});
    const PreparedScene prepared(scene);
    for (const LightStrategy strategy : {LightStrategy::mis, LightStrategy::light_sampling}) {
      settings.strategy = strategy;
      const Estimate found = mean_luminance(prepared, settings, 2500, 21);
      EXPECT_NEAR(found.mean, expected, 0.01 * expected);
      EXPECT_LT(found.error, 0.0025 * expected) << "the test would prove nothing";
    }
  }
  // Above the lamp it is dark.
  scene.objects[0].mesh = make_ground(10, 1, 0, 1, 0);
  place(scene.objects[0].mesh, grey(1), {}, {0, 3, 0});
  scene.camera = simple_camera({0, 8, 4}, {0, 3, 0}, 0.2F, 4);
  EXPECT_EQ(mean_luminance(PreparedScene(scene), settings, 20, 22).mean, 0);
}

/// A corner with two lamps, a sun and every material that light sampling can serve.
Scene mixed_scene(bool glass) {
  Scene scene;
  scene.objects.push_back({make_ground(3, 1, 0, 1, 0), 0, {}});
  scene.objects.push_back({make_parallelogram({-3, 0, -2}, {6, 0, 0}, {0, 4, 0}), 1, {}});
  const auto add = [&](Mesh mesh, float size, Vec3 centre, Vec3 motion, int material) {
    place(mesh, grey(size), look_at({}, {1, 2, 3}, {0, 1, 0}), centre);
    scene.objects.push_back({mesh, material, motion});
  };
  add(make_sphere(3), 0.7F, {-1, 0.7F, 0}, {0.3F, 0, 0}, 2);
  add(make_torus(0.3F, 24, 12), 0.6F, {1, 0.8F, 0}, {}, 3);
  add(make_box(), 0.4F, {0, 0.6F, 1}, {0, 0.2F, 0}, glass ? 4 : 3);
  scene.materials = {plain_material(MaterialKind::diffuse, {0.6F, 0.5F, 0.4F}),
                     plain_material(MaterialKind::rough_conductor, {0.7F, 0.8F, 0.9F}, 0.7F),
                     plain_material(MaterialKind::rough_conductor, {0.9F, 0.7F, 0.4F}, 0.5F),
                     plain_material(MaterialKind::diffuse, {0.2F, 0.6F, 0.8F}),
                     plain_material(MaterialKind::rough_dielectric, grey(1), 0.6F)};
  scene.lights.push_back({{-1, 2.5F, 0}, {1.2F, 0, 0}, {0, 0, 1}, {3, 3, 2}});
  scene.lights.push_back({{2.5F, 0.5F, -1}, {0, 0, 1}, {0, 1.2F, 0}, {2, 1, 4}});
  Sky sky;
  sky.zenith = {0.2F, 0.3F, 0.5F};
  sky.horizon = {0.5F, 0.4F, 0.4F};
  sky.ground = grey(0.1F);
  sky.patches.push_back({normalize(Vec3{1, 1, 1}), std::cos(0.35F), grey(3)});
  scene.sky = sky;
  scene.camera = simple_camera({0.5F, 2, 5}, {0, 0.6F, 0}, 0.7F, 12);
  scene.camera.lens_radius = 0.1F;
  scene.camera.focus_distance = 5;
  scene.camera.shutter = true;
  return scene;
}

TEST(DirectLight, StrategiesAgree) {
  const PreparedScene scene(mixed_scene(true));
  for (const int bounces : {1, 3}) {
    PathSettings settings;
    settings.max_bounces = bounces;
    Estimate found[3];
    for (int i = 0; i < 3; ++i) {
      settings.strategy = static_cast<LightStrategy>(i);
      found[i] = mean_luminance(scene, settings, 500, 31 + static_cast<uint64_t>(i));
      EXPECT_LT(found[i].error, 0.015 * found[i].mean);
    }
    EXPECT_LT(z_score(found[0], found[1]), 4)
        << found[0].mean << " MIS, " << found[1].mean << " light sampling";
    EXPECT_LT(z_score(found[0], found[2]), 4)
        << found[0].mean << " MIS, " << found[2].mean << " BSDF sampling";
    // MIS need not beat both, but it must not be much worse than the better one.
    EXPECT_LT(found[0].error, 1.5 * std::min(found[1].error, found[2].error));
  }
}

TEST(DirectLight, FramesConvergeToTheReference) {
  // No smooth or glossy caster: what the samples see, the reference sees.
  const PreparedScene scene(mixed_scene(false));
  RenderSettings settings;
  settings.seed = 5;
  settings.threads = 2;
  constexpr int kFrames = 64, kBlock = 4, kSide = 12 / kBlock;
  // Means over blocks of the picture, frame by frame: independent numbers whose spread is measured, not
  // assumed.
  double sum[kSide][kSide] = {}, squares[kSide][kSide] = {};
  settings.spp = 8;
  for (uint32_t f = 0; f < kFrames; ++f) {
    settings.frame = f;
    const Image mean = mean_radiance(*render_samples(scene, settings));
    for (int by = 0; by < kSide; ++by)
      for (int bx = 0; bx < kSide; ++bx) {
        double block = 0;
        for (int c = 0; c < 3; ++c)
          for (int y = 0; y < kBlock; ++y)
            for (int x = 0; x < kBlock; ++x) block += mean.at(c, bx * kBlock + x, by * kBlock + y);
        sum[by][bx] += block;
        squares[by][bx] += block * block;
      }
  }
  settings.frame = 0;
  settings.spp = 4096;
  const Image reference = *render_reference(scene, settings);
  double chi2 = 0;
  for (int by = 0; by < kSide; ++by)
    for (int bx = 0; bx < kSide; ++bx) {
      double expected = 0;
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < kBlock; ++y)
          for (int x = 0; x < kBlock; ++x) expected += reference.at(c, bx * kBlock + x, by * kBlock + y);
      const double mean = sum[by][bx] / kFrames;
      const double variance = (squares[by][bx] / kFrames - mean * mean) / (kFrames - 1);
      // The reference took 8 times as many samples as all frames together: an eighth of their variance is its
      // own.
      const double z = (mean - expected) / std::sqrt(variance * (1 + 1.0 / 8));
      EXPECT_LT(std::abs(z), 4) << "block " << bx << ", " << by << ": " << mean << " against " << expected;
      EXPECT_LT(std::sqrt(variance), 0.02 * mean) << "the test would prove nothing";
      chi2 += z * z;
    }
  EXPECT_LT(chi2, 9 + 4 * std::sqrt(2.0 * 9));
}

TEST(Sky, SamplingMatchesItsDensityAndRadiance) {
  Sky sky;
  sky.zenith = {0.2F, 0.4F, 0.9F};
  sky.horizon = {0.9F, 0.7F, 0.5F};
  sky.ground = {0.1F, 0.1F, 0.1F};
  sky.patches.push_back({normalize(Vec3{1, 0.5F, 0.2F}), std::cos(0.1F), {30, 28, 25}});
  sky.patches.push_back({normalize(Vec3{-1, 1, 0.2F}), std::cos(0.4F), {1, 2, 3}});
  const SkySampler sampler(sky);
  double mass = 0, power = 0;
  constexpr int kGrid = 1000;
  for (int i = 0; i < kGrid; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const float y = -1 + 2 * (static_cast<float>(i) + 0.5F) / kGrid,
                  phi = 2 * kPi * (static_cast<float>(j) + 0.5F) / kGrid;
      const float r = std::sqrt(1 - y * y);
      const Vec3 d = {r * std::cos(phi), y, r * std::sin(phi)};
      mass += sampler.pdf(d) * 4 * kPi / (kGrid * kGrid);
      power += luminance(sky.radiance(d)) * 4 * kPi / (kGrid * kGrid);
    }
  EXPECT_NEAR(mass, 1, 0.005);
  EXPECT_NEAR(sampler.power(), power, 0.02 * power);
  RandomStream random(7, RandomPurpose::test);
  double sum = 0, squares = 0, upward = 0, upward_weighted = 0;
  constexpr int kDraws = 100000;
  for (int k = 0; k < kDraws; ++k) {
    const float u0 = random.uniform(), u1 = random.uniform(), u2 = random.uniform();
    const SkySample drawn = sampler.sample(u0, u1, u2);
    ASSERT_NEAR(length(drawn.direction), 1, 1e-5);
    const double estimate = luminance(sky.radiance(drawn.direction)) / drawn.pdf;
    sum += estimate;
    squares += estimate * estimate;
    upward += 1 / drawn.pdf;  // the sphere's area
    upward_weighted += drawn.direction.y / drawn.pdf;
  }
  const double mean = sum / kDraws, error = std::sqrt((squares / kDraws - mean * mean) / kDraws);
  EXPECT_NEAR(mean, power, 4 * error + 0.002 * power);
  EXPECT_LT(error, 0.003 * power) << "importance sampling leaves little variance";
  EXPECT_NEAR(upward / kDraws, 4 * kPi, 0.15);
  EXPECT_NEAR(upward_weighted / kDraws, 0, 0.15);
}

}  // namespace
}  // namespace ld
