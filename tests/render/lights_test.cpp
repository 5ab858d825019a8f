// Lights of every kind against closed forms, brute force and each other.
#include <gtest/gtest.h>

#include <vector>

#include "tests/render/test_scenes.h"

namespace ld {
namespace {

/// A grey floor, seen in one spot at the origin.
Scene floor_spot() {
  Scene scene;
  scene.objects.push_back({make_ground(10, 1, 0, 1, 0), 0, {}});
  scene.materials.push_back(plain_material(MaterialKind::diffuse, grey(0.5F)));
  scene.camera = simple_camera({12, 9, 3}, {0, 0, 0}, 1e-4F, 4);
  return scene;
}

double spot_luminance(const Scene& scene) {
  PathSettings settings;
  settings.max_bounces = 1;
  return mean_luminance(PreparedScene(scene), settings, 100, 3).mean;
}

TEST(Lights, PointLightFallsWithTheSquare) {
  Scene scene = floor_spot();
  scene.point_lights.push_back({{0, 3, 4}, grey(20)});
  // Irradiance I cos / d^2, d = 5, cos = 3 / 5.
  EXPECT_NEAR(spot_luminance(scene), 0.5 / kPi * 20 * 0.6 / 25, 1e-5);
}

TEST(Lights, SpotsShineWithinTheirCone) {
  Scene scene = floor_spot();
  PointLight spot = {{0, 4, 0}, grey(16), {0, -1, 0}, std::cos(0.3F), std::cos(0.5F)};
  scene.point_lights.push_back(spot);
  EXPECT_NEAR(spot_luminance(scene), 0.5 / kPi, 1e-5);
  const auto turned = [&](float angle) {
    scene.point_lights[0].direction = {std::sin(angle), -std::cos(angle), 0};
    return spot_luminance(scene);
  };
  EXPECT_NEAR(turned(0.29F), 0.5 / kPi, 1e-5);
  EXPECT_EQ(turned(0.51F), 0);
  EXPECT_GT(turned(0.4F), 0);
  EXPECT_LT(turned(0.4F), 0.5 / kPi);
}

TEST(Lights, ParallelLightIsTheSameEverywhere) {
  Scene scene = floor_spot();
  scene.directional_lights.push_back({normalize(Vec3{0, 3, 4}), grey(2)});
  EXPECT_NEAR(spot_luminance(scene), 0.5 / kPi * 2 * 0.6, 1e-5);
  // A roof puts it in the shade.
  scene.objects.push_back({make_parallelogram({-2, 1, -2}, {0, 0, 6}, {4, 0, 0}), 0, {}});
  scene.camera = simple_camera({3, 0.4F, 0}, {0, 0, 0}, 1e-4F, 4);
  EXPECT_EQ(spot_luminance(scene), 0);
}

/// A white ball on a floor in a corner, with a lamp that is a mesh.
Scene lamp_scene(bool mesh_lamp) {
  Scene scene;
  scene.objects.push_back({make_ground(3, 1, 0, 1, 0), 0, {}});
  Mesh ball = make_sphere(3);
  place(ball, grey(0.6F), {}, {0.5F, 0.6F, 0});
  scene.objects.push_back({ball, 1, {}});
  scene.materials = {plain_material(MaterialKind::diffuse, {0.6F, 0.5F, 0.4F}),
                     plain_material(MaterialKind::rough_conductor, {0.9F, 0.7F, 0.4F}, 0.6F),
                     plain_material(MaterialKind::diffuse, grey(0))};
  const AreaLight lamp = {{-1.5F, 1.5F, 0}, {1.2F, 0, 0}, {0, 0, 1}, {3, 3, 2}};
  if (mesh_lamp) {
    scene.materials[2].emission = plain_texture(lamp.radiance);
    scene.objects.push_back({make_parallelogram(lamp.corner, lamp.edge_u, lamp.edge_v), 2, {}});
  } else {
    scene.lights.push_back(lamp);
  }
  scene.camera = simple_camera({0.5F, 2, 5}, {0, 0.6F, 0}, 0.7F, 12);
  return scene;
}

void expect_strategies_agree(const Scene& scene, double largest_error) {
  const PreparedScene prepared(scene);
  PathSettings settings;
  settings.max_bounces = 3;
  Estimate found[3];
  for (int i = 0; i < 3; ++i) {
    settings.strategy = static_cast<LightStrategy>(i);
    found[i] = mean_luminance(prepared, settings, 600, 41 + static_cast<uint64_t>(i));
    EXPECT_LT(found[i].error, largest_error * found[i].mean) << i;
  }
  EXPECT_LT(z_score(found[0], found[1]), 4)
      << found[0].mean << " MIS, " << found[1].mean << " light sampling";
  EXPECT_LT(z_score(found[0], found[2]), 4) << found[0].mean << " MIS, " << found[2].mean << " BSDF sampling";
}

TEST(Lights, MeshesThatEmitAreLikeLamps) {
  const Estimate mesh = mean_luminance(PreparedScene(lamp_scene(true)), {}, 600, 5);
  const Estimate lamp = mean_luminance(PreparedScene(lamp_scene(false)), {}, 600, 6);
  EXPECT_LT(z_score(mesh, lamp), 4) << mesh.mean << " and " << lamp.mean;
  EXPECT_LT(mesh.error, 0.01 * mesh.mean);
  expect_strategies_agree(lamp_scene(true), 0.03);
}

TEST(Lights, TurningLampsAndCoatsAgreeInEveryStrategy) {
  Scene scene = lamp_scene(true);
  scene.camera.shutter = true;
  scene.objects[2].motion.translation = {0.2F, 0.3F, 0};
  scene.objects[2].motion.angle = 1.2F;
  scene.objects[2].motion.axis = normalize(Vec3{1, 0.2F, 0.1F});
  scene.objects[2].motion.pivot = {-1, 1.5F, 0.5F};
  scene.materials[0] = plain_material(MaterialKind::plastic, {0.6F, 0.5F, 0.4F}, 0.5F);
  scene.materials[1] = plain_material(MaterialKind::coated_metal, {0.9F, 0.7F, 0.4F}, 0.5F);
  expect_strategies_agree(scene, 0.04);
}

/// Dim with one bright patch away from the poles.
std::shared_ptr<const TextureImage> probe_image() {
  auto image = std::make_shared<TextureImage>();
  image->width = 32;
  image->height = 16;
  for (int j = 0; j < 16; ++j)
    for (int i = 0; i < 32; ++i) {
      const bool sun = j >= 3 && j < 5 && i >= 20 && i < 23;
      image->texels.push_back(
          sun ? Vec3{40, 36, 30}
              : Vec3{0.1F + 0.02F * static_cast<float>(i), 0.3F, 0.05F * static_cast<float>(j)});
    }
  return image;
}

Probe test_probe() {
  return {probe_image(), look_at({}, {0.3F, -0.2F, -1}, {0.1F, 1, 0}), {1, 0.8F, 1.2F}};
}

TEST(Probe, ADirectionFindsItsTexel) {
  Probe probe = {probe_image(), {}, {1, 1, 1}};
  const auto texel = [&](int i, int j) { return probe.image->texels[static_cast<size_t>(j * 32 + i)]; };
  // Row 0 is up; the middle of the picture looks along -z, its right half along +x.
  EXPECT_NEAR(probe.radiance({0, 1, 0}).z, 0, 1e-5);
  EXPECT_NEAR(probe.radiance({0, -1, 0}).z, 0.75, 1e-5);
  EXPECT_NEAR(probe.radiance({0, 0, -1}).x, 0.5F * (texel(15, 8).x + texel(16, 8).x), 1e-4);
  EXPECT_NEAR(probe.radiance({1, 0, 0}).x, 0.5F * (texel(23, 8).x + texel(24, 8).x), 1e-4);
  EXPECT_NEAR(probe.radiance({-1, 0, 0}).x, 0.5F * (texel(7, 8).x + texel(8, 8).x), 1e-4);
}

TEST(Probe, SamplesFollowTheirDensity) {
  const ProbeSampler sampler(test_probe());
  constexpr int kPolar = 12, kAzimuths = 24, kFine = 40, kDraws = 200000;
  const auto bin = [&](Vec3 d) {
    const int i = std::clamp(static_cast<int>((d.y + 1) * 0.5F * kPolar), 0, kPolar - 1);
    const float turn = (std::atan2(d.z, d.x) + kPi) / (2 * kPi);
    return static_cast<size_t>(i * kAzimuths +
                               std::clamp(static_cast<int>(turn * kAzimuths), 0, kAzimuths - 1));
  };
  std::vector<double> mass(size_t{kPolar} * kAzimuths), counts(mass.size());
  const int rows = kPolar * kFine, columns = kAzimuths * kFine;
  for (int i = 0; i < rows; ++i)
    for (int j = 0; j < columns; ++j) {
      const float y = -1 + 2 * (static_cast<float>(i) + 0.5F) / static_cast<float>(rows);
      const float phi = -kPi + 2 * kPi * (static_cast<float>(j) + 0.5F) / static_cast<float>(columns);
      const float r = std::sqrt(1 - y * y);
      const Vec3 d = {r * std::cos(phi), y, r * std::sin(phi)};
      mass[bin(d)] += static_cast<double>(sampler.pdf(d)) * 4 * static_cast<double>(kPi) / (rows * columns);
    }
  RandomStream random(15, RandomPurpose::test);
  int beside = 0;
  for (int k = 0; k < kDraws; ++k) {
    const float u = random.uniform(), v = random.uniform();
    const SkySample drawn = sampler.sample(u, v);
    if (std::abs(drawn.pdf - sampler.pdf(drawn.direction)) > 1e-3F * drawn.pdf) ++beside;
    ++counts[bin(drawn.direction)];
  }
  double total = 0, chi2 = 0;
  for (size_t b = 0; b < mass.size(); ++b) {
    total += mass[b];
    const double expected = mass[b] * kDraws;
    ASSERT_GT(expected, 10);
    chi2 += (counts[b] - expected) * (counts[b] - expected) / expected;
  }
  EXPECT_NEAR(total, 1, 0.005);
  EXPECT_LT(beside, kDraws / 10000) << "only draws on the very edge of a texel may round to its neighbour";
  const double n = static_cast<double>(mass.size());
  // The quadrature misses the edges of bright texels by a little.
  EXPECT_LT(chi2, n + 6 * std::sqrt(2 * n));
}

TEST(Probe, LightsAFloorAsBruteForceSays) {
  Scene scene = floor_spot();
  scene.probe = test_probe();
  constexpr int kGrid = 2000, kRows = kGrid / 2;
  double irradiance = 0;
  for (int i = 0; i < kRows; ++i)
    for (int j = 0; j < kGrid; ++j) {
      const float y = (static_cast<float>(i) + 0.5F) / kRows;
      const float phi = 2 * kPi * (static_cast<float>(j) + 0.5F) / kGrid, r = std::sqrt(1 - y * y);
      irradiance += static_cast<double>(
                        luminance(scene.probe->radiance({r * std::cos(phi), y, r * std::sin(phi)})) * y) *
                    2 * static_cast<double>(kPi) / (kGrid * kGrid / 2.0);
    }
  PathSettings settings;
  settings.max_bounces = 1;
  const double expected = 0.5 / static_cast<double>(kPi) * irradiance;
  for (const LightStrategy strategy : {LightStrategy::mis, LightStrategy::light_sampling}) {
    settings.strategy = strategy;
    const Estimate found = mean_luminance(PreparedScene(scene), settings, 4000, 16);
    EXPECT_NEAR(found.mean, expected, 4 * found.error);
    EXPECT_LT(found.error, 0.004 * expected) << "importance sampling leaves little variance";
  }
  settings.strategy = LightStrategy::bsdf_sampling;
  const Estimate blind = mean_luminance(PreparedScene(scene), settings, 4000, 17);
  EXPECT_NEAR(blind.mean, expected, 4 * blind.error);
}

TEST(Probe, StrategiesAgreeUnderIt) {
  Scene scene = lamp_scene(true);
  scene.probe = test_probe();
  expect_strategies_agree(scene, 0.06);
}

TEST(Lights, ScalingScalesEverything) {
  Scene scene = lamp_scene(true);
  scene.lights.push_back({{2.5F, 0.5F, -1}, {0, 0, 1}, {0, 1.2F, 0}, {2, 1, 4}});
  scene.point_lights.push_back({{0, 3, 1}, grey(2)});
  scene.directional_lights.push_back({normalize(Vec3{0, 3, 4}), grey(0.2F)});
  scene.probe = test_probe();
  PreparedScene prepared(scene);
  const double before = mean_luminance(prepared, {}, 8, 18).mean;
  prepared.scale_lights(4);
  EXPECT_NEAR(mean_luminance(prepared, {}, 8, 18).mean, 4 * before, 1e-4 * before);
}

}  // namespace
}  // namespace ld
