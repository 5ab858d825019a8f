// Lens and shutter against closed forms: the circle of confusion, the sweep of a moving edge, turning objects
// and cameras.
#include <gtest/gtest.h>

#include <vector>

#include "render/trace/image_renderer.h"
#include "tests/render/test_scenes.h"

namespace ld {
namespace {

/// A square that shines, of this side, centred at (0, 0, -depth), facing a camera at the origin.
Scene shining_square(float side, float depth, int size) {
  Scene scene;
  scene.lights.push_back({{-side / 2, -side / 2, -depth}, {side, 0, 0}, {0, side, 0}, grey(1)});
  scene.camera =
      simple_camera({0, 0, 0}, {0, 0, -1}, 2 * std::atan(0.5F), size);  // focal length: `size` pixels
  return scene;
}

Image picture(const Scene& scene, int spp) {
  RenderSettings settings;
  settings.seed = 9;
  settings.spp = spp;
  settings.threads = 2;
  return *render_reference(PreparedScene(scene), settings);
}

TEST(Movement, APointBlursToItsCircleOfConfusion) {
  for (const float depth : {3.0F, 9.0F}) {
    constexpr float kSide = 0.15F;
    Scene scene = shining_square(kSide, depth, 64);
    scene.camera.lens_radius = 0.5F;
    scene.camera.focus_distance = 5;
    const Image image = picture(scene, 1024);
    const double radius = std::abs(scene.camera.circle_of_confusion(depth));
    EXPECT_NEAR(radius, 0.5 * std::abs(1 / 5.0 - 1 / static_cast<double>(depth)) * 64, 1e-4);
    double sum = 0, inertia = 0, outside = 0;
    for (int y = 0; y < 64; ++y)
      for (int x = 0; x < 64; ++x) {
        const double dx = x + 0.5 - 32, dy = y + 0.5 - 32, v = image.at(0, x, y), r = std::hypot(dx, dy);
        sum += v;
        inertia += v * r * r;
        if (r > radius + 4) outside += v;
      }
    // A uniform disk has a mean squared radius of half its radius squared; pixels of width 1 and the square,
    // which is some pixels wide, add a sixth of their widths squared.
    const double pixels = 64 * static_cast<double>(kSide / depth);
    EXPECT_NEAR(inertia / sum, radius * radius / 2 + (1 + pixels * pixels) / 6, 0.02 * radius * radius);
    EXPECT_EQ(outside, 0);
    EXPECT_NEAR(sum, pixels * pixels, 0.08 * pixels * pixels) << "all of its light arrives";
  }
}

TEST(Movement, ASweepingEdgeFadesLinearly) {
  Scene scene;
  // 16 pixels a unit at depth 4 of 64: the square is 8 pixels wide and sweeps 16 pixels to the right.
  scene.objects.push_back({make_parallelogram({-1, -2, -4}, {0.5F, 0, 0}, {0, 4, 0}), 0, Vec3{1, 0, 0}});
  scene.materials.push_back(plain_material(MaterialKind::diffuse, grey(0)));
  scene.materials[0].emission = plain_texture(grey(1));
  scene.camera = shining_square(1, 1, 64).camera;
  scene.camera.shutter = true;
  const Image image = picture(scene, 1024);
  for (int x = 0; x < 64; ++x) {
    // The share of time and pixel that lies within [left, left + 8] with left going from 16 to 32.
    double expected = 0;
    constexpr int kSteps = 4000;
    for (int k = 0; k < kSteps; ++k) {
      const double left = 16 + 16 * (k + 0.5) / kSteps;
      expected += std::clamp(left + 8 - x, 0.0, 1.0) - std::clamp(left - x, 0.0, 1.0);
    }
    EXPECT_NEAR(image.at(0, x, 32), expected / kSteps, 0.006) << "column " << x;
  }
}

TEST(Movement, TurningGoesRoundTheAxis) {
  Motion motion;
  motion.axis = {0, 0, 1};
  motion.angle = kPi / 2;
  motion.pivot = {1, 1, 0};
  motion.translation = {0, 0, -2};
  for (const float time : {0.0F, 0.37F, 0.5F, 1.0F}) {
    const Vec3 p = motion.point({2, 1, 5}, time);
    EXPECT_NEAR(p.x, 1 + std::cos(time * kPi / 2), 6e-4);
    EXPECT_NEAR(p.y, 1 + std::sin(time * kPi / 2), 6e-4);
    EXPECT_NEAR(p.z, 5 - 2 * time, 1e-5);
    EXPECT_NEAR(motion.direction({1, 0, 0}, time).y, std::sin(time * kPi / 2), 1e-5);
  }
  EXPECT_EQ(motion.point({2, 1, 5}, 0).x, 2) << "at time 0 it is where it is, to the bit";
}

TEST(Movement, TheTracerFindsTurningObjectsWhereTheyAre) {
  Scene scene;
  Mesh arm = make_box();
  place(arm, {1, 0.1F, 0.1F}, {}, {1, 0, -6});  // from the pivot to 2 on the right
  Motion motion;
  motion.axis = {0, 0, 1};
  motion.angle = kPi / 2;
  motion.pivot = {0, 0, -6};
  scene.objects.push_back({arm, 0, motion});
  scene.materials.push_back({});
  scene.camera.shutter = true;
  const PreparedScene prepared(scene);
  for (const float time : {0.0F, 0.2F, 0.55F, 0.9F, 1.0F}) {
    const Vec3 tip = {1.9F * std::cos(time * kPi / 2), 1.9F * std::sin(time * kPi / 2), -5.9F};
    const auto hit = prepared.trace({{tip.x, tip.y, 0}, {0, 0, -1}}, time);
    ASSERT_TRUE(hit.has_value()) << time;
    EXPECT_NEAR(hit->position.z, -5.9F, 1e-3);
    EXPECT_NEAR(hit->position.x, tip.x, 1e-3);
    EXPECT_NEAR(hit->position.y, tip.y, 1e-3);
    EXPECT_NEAR(hit->at_open.x, 1.9F, 3e-3) << "and knows where that point was at shutter open";
    EXPECT_NEAR(hit->at_open.y, 0, 3e-3);
    EXPECT_NEAR(hit->shading_normal.z, 1, 1e-4);
    const auto miss = prepared.trace({{tip.y + 0.5F, -tip.x, 0}, {0, 0, -1}}, time);
    EXPECT_FALSE(miss.has_value()) << time;
  }
}

/// A wall at depth 8 seen by a camera of focal length 64 pixels.
Scene wall() {
  Scene scene;
  scene.objects.push_back({make_parallelogram({-40, -40, -8}, {80, 0, 0}, {0, 80, 0}), 0, {}});
  scene.materials.push_back(plain_material(MaterialKind::diffuse, grey(0.5F)));
  scene.camera = shining_square(1, 1, 64).camera;
  return scene;
}

Guides guides_at(const Scene& scene, const CameraSample& where) {
  const PreparedScene prepared(scene);
  SampleNumbers numbers(RandomStream(1, RandomPurpose::test));
  Guides guides;
  trace_path(prepared, scene.camera.at(where.time).ray(where), where.time, numbers, {}, &guides);
  return guides;
}

TEST(Movement, MovingCamerasSeeStandingThingsMove) {
  Scene scene = wall();
  scene.camera.shutter = true;
  scene.camera.close = CameraPose{{1, 0.5F, 0}, scene.camera.axes};  // to the right and up: 8 and 4 pixels
  for (const float time : {0.0F, 0.5F, 1.0F}) {
    const Guides guides = guides_at(scene, {20, 40, {}, time});
    EXPECT_NEAR(guides.motion.x, -8, 1e-3);
    EXPECT_NEAR(guides.motion.y, 4, 1e-3);
  }
  // Turning to the left by a: what was in the middle goes right by 64 tan a, near and far alike.
  const float a = 0.1F;
  scene.camera.close = CameraPose{{}, look_at({}, {-std::sin(a), 0, -std::cos(a)}, {0, 1, 0})};
  EXPECT_NEAR(guides_at(scene, {32, 32, {}, 0}).motion.x, 64 * std::tan(a), 1e-3);
  scene.objects[0].mesh = make_parallelogram({-40, -40, 9}, {80, 0, 0}, {0, 80, 0});  // behind the camera
  EXPECT_NEAR(guides_at(scene, {32, 32, {}, 0}).motion.x, 64 * std::tan(a), 1e-3) << "so does the sky";
  EXPECT_NEAR(guides_at(scene, {32, 32, {}, 0}).motion.y, 0, 1e-3);
}

TEST(Movement, CamerasTurnEvenly) {
  Camera camera;
  camera.shutter = true;
  const float a = 1.2F;
  camera.close = CameraPose{{2, 0, 4}, look_at({}, {-std::sin(a), 0, -std::cos(a)}, {0, 1, 0})};
  const Camera half = camera.at(0.5F);
  EXPECT_NEAR(half.position.x, 1, 1e-6);
  EXPECT_NEAR(half.axes.z.x, std::sin(a / 2), 1e-5);
  EXPECT_NEAR(half.axes.z.z, std::cos(a / 2), 1e-5);
  EXPECT_NEAR(dot(half.axes.x, half.axes.y), 0, 1e-6);
  EXPECT_NEAR(camera.at(1).axes.z.x, std::sin(a), 1e-5);
  camera.shutter = false;
  EXPECT_EQ(camera.at(1).position.x, 0) << "an instant shutter sees no movement";
}

TEST(Movement, FlowLeadsToThePreviousFrame) {
  Scene scene = wall();
  scene.camera.previous = CameraPose{{-1, 0, 0}, scene.camera.axes};  // it has come from the left
  Guides guides = guides_at(scene, {20, 40, {}, 0});
  EXPECT_NEAR(guides.flow.x, 8, 1e-3) << "the wall was further right in the picture";
  EXPECT_NEAR(guides.flow.y, 0, 1e-3);
  scene.camera.previous.reset();
  scene.objects[0].previous.translation = {0, -0.5F, 0};  // it has come from below
  guides = guides_at(scene, {20, 40, {}, 0});
  EXPECT_NEAR(guides.flow.x, 0, 1e-3);
  EXPECT_NEAR(guides.flow.y, 4, 1e-3) << "+y is down";
}

TEST(Movement, IndependentPairsDifferByOneOverTheRootOfTheirSamples) {
  Scene scene = wall();
  Mesh ball = make_sphere(3);
  place(ball, grey(1), {}, {0, 0, -5});
  scene.objects.push_back({ball, 1, Vec3{0.5F, 0, 0}});
  scene.materials.push_back(plain_material(MaterialKind::diffuse, {0.7F, 0.2F, 0.2F}));
  scene.lights.push_back({{-1, 3, -5}, {2, 0, 0}, {0, 0, 2}, grey(8)});
  scene.sky = constant_sky(0.2F);
  scene.camera.width = scene.camera.height = 12;
  scene.camera.shutter = true;
  scene.camera.lens_radius = 0.1F;
  scene.camera.focus_distance = 5;
  const PreparedScene prepared(scene);
  RenderSettings settings;
  settings.threads = 2;
  const auto mean_of = [&](int spp, uint64_t seed) {
    settings.spp = spp;
    settings.seed = seed;
    return mean_radiance(*render_samples(prepared, settings));
  };
  std::vector<double> scaled;
  for (const int spp : {16, 64, 256, 1024, 4096}) {
    const Image a = mean_of(spp, 100), b = mean_of(spp, 200);
    double squares = 0;
    for (size_t i = 0; i < a.pixels.size(); ++i)
      squares +=
          static_cast<double>(a.pixels[i] - b.pixels[i]) * static_cast<double>(a.pixels[i] - b.pixels[i]);
    scaled.push_back(std::sqrt(squares / static_cast<double>(a.pixels.size()) * spp));
  }
  // The same number throughout. Rare bright paths shake it at few samples.
  for (const double value : scaled) EXPECT_NEAR(value / scaled.back(), 1, 0.5);
  EXPECT_NEAR(std::log(scaled.front() / scaled.back()) / std::log(256.0), 0, 0.04);
}

}  // namespace
}  // namespace ld
