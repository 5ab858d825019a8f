// What classical filters read, as the tracer finds it: parts of radiance, ids, the depth at the end of flow,
// the camera's matrices.
#include <gtest/gtest.h>

#include <map>

#include "render/random/random_scene.h"
#include "render/recipe/scene_source.h"
#include "render/trace/image_renderer.h"
#include "tests/render/test_scenes.h"
#include "tests/support/flip_scene.h"

namespace ld {
namespace {

Frame rendered(const PreparedScene& scene, int spp, const PathSettings& path = {}) {
  RenderSettings settings;
  settings.seed = 3;
  settings.spp = spp;
  settings.filter_guides = true;
  settings.path = path;
  return *render_samples(scene, settings);
}

/// A textured room with a mirror, glass, a metal, a shining ball, a lamp, a point light and a sky seen
/// through the open front.
Scene open_room(Vec3 walls) {
  Scene scene = flip_scene({}, 24);
  scene.camera.shutter = false;
  Material wall = plain_material(MaterialKind::diffuse, walls), ball = wall;
  ball.emission = plain_texture({0.5F, 0.4F, 0.3F});
  scene.objects.push_back(
      {make_parallelogram({-2, -2, -7}, {4, 0, 0}, {0, 4, 0}), int(scene.materials.size()), {}});
  scene.materials.push_back(wall);
  Mesh sphere = make_sphere(3);
  place(sphere, grey(0.4F), {}, {0, 0.2F, -3});
  scene.objects.push_back({sphere, int(scene.materials.size()), {}});
  scene.materials.push_back(ball);
  scene.point_lights.push_back({{0.5F, 0.6F, -2}, {1, 1, 1}});
  scene.sky = constant_sky(0.3F);
  return scene;
}

float largest_miss(const Frame& frame) {
  float most = 0;
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p)
      for (int c = 0; c < 3; ++c) {
        const float whole = frame.plane(s, c)[p], sum = frame.plane(s, kDirectOffset + c)[p] +
                                                        frame.plane(s, kIndirectOffset + c)[p] +
                                                        frame.plane(s, kEmissionOffset + c)[p];
        most = std::max(most, std::abs(sum - whole) / std::max(whole, 1e-3F));
      }
  return most;
}

TEST(RadianceParts, AddUpToRadiance) {
  const PreparedScene room(open_room(grey(0.7F)));
  for (const LightStrategy strategy :
       {LightStrategy::mis, LightStrategy::light_sampling, LightStrategy::bsdf_sampling})
    for (const bool biased : {false, true}) {
      PathSettings path;
      path.strategy = strategy;
      path.guides_through_specular = biased;
      path.regularisation = biased ? 0.4F : 0;
      path.indirect_clamp = biased ? 0.5F : 0;
      const Frame frame = rendered(room, 4, path);
      EXPECT_LT(largest_miss(frame), 1e-5F);
      double sums[3] = {0, 0, 0};
      for (int k = 0; k < 3; ++k)
        for (size_t p = 0; p < frame.plane_size(); ++p) sums[k] += frame.plane(0, kDirectOffset + 3 * k)[p];
      for (const double sum : sums) EXPECT_GT(sum, 1) << "each part is there";
    }
  SceneConfig config;
  config.objects = {5, 8};
  for (uint32_t number = 0; number < 4; ++number)
    EXPECT_LT(largest_miss(rendered(*prepare_random_scene(config, 5, number, 24, 16), 2)), 1e-5F);
}

TEST(RadianceParts, GoByTheNumberOfSegments) {
  const PreparedScene room(open_room(grey(0.7F)));
  PathSettings path;
  path.max_bounces = 0;
  Frame frame = rendered(room, 1, path);
  for (size_t i = 0; i < 3 * frame.plane_size(); ++i) {
    EXPECT_EQ(frame.plane(0, kEmissionOffset)[i], frame.plane(0, 0)[i]);
    EXPECT_EQ(frame.plane(0, kDirectOffset)[i] + frame.plane(0, kIndirectOffset)[i], 0);
  }
  // Emission is no estimate: the sky's where the ray escaped, none on walls.
  bool seen[2] = {false, false};
  for (size_t p = 0; p < frame.plane_size(); ++p) {
    const bool escaped = frame.plane(0, kDepthOffset)[p] >= kEscapedDepth;
    seen[escaped ? 1 : 0] = true;
    if (escaped) {
      EXPECT_FLOAT_EQ(frame.plane(0, kEmissionOffset)[p], 0.3F);
    }
  }
  EXPECT_TRUE(seen[0] && seen[1]);
  path.max_bounces = 1;
  frame = rendered(room, 1, path);
  EXPECT_EQ(*std::max_element(frame.plane(0, kIndirectOffset),
                              frame.plane(0, kIndirectOffset) + 3 * frame.plane_size()),
            0);
}

TEST(RadianceParts, DirectIsTheSameByEveryTechnique) {
  Scene scene = open_room(grey(0.7F));
  scene.point_lights.clear();  // which nothing but light sampling finds
  const PreparedScene room(std::move(scene));
  double mean[2][3], error[2][3];
  for (const int k : {0, 1}) {
    PathSettings path;
    path.strategy = k == 0 ? LightStrategy::mis : LightStrategy::bsdf_sampling;
    const Frame frame = rendered(room, k == 0 ? 64 : 256, path);
    for (const int part : {0, 1}) {
      double sum = 0, squares = 0;
      for (int s = 0; s < frame.spp; ++s)
        for (size_t p = 0; p < frame.plane_size(); ++p) {
          const double v = frame.plane(s, kDirectOffset + 3 * part)[p];
          sum += v;
          squares += v * v;
        }
      const double n = double(frame.spp) * double(frame.plane_size());
      mean[k][part] = sum / n;
      error[k][part] = std::sqrt((squares / n - sum / n * sum / n) / n);
    }
  }
  for (const int part : {0, 1})
    EXPECT_LT(std::abs(mean[0][part] - mean[1][part]), 4 * std::hypot(error[0][part], error[1][part]))
        << part << ": " << mean[0][part] << " and " << mean[1][part];
}

TEST(RadianceParts, DirectIsAllWhereNothingElseScatters) {
  // A white floor under a lamp in a black room: what the floor sends on is lost.
  Scene scene;
  scene.materials = {plain_material(MaterialKind::diffuse, grey(0.8F)),
                     plain_material(MaterialKind::diffuse, {})};
  scene.objects.push_back({make_ground(1, 1, 0, 1, 0), 0, {}});
  Mesh room = make_box();
  place(room, grey(4), {}, {0, 3.5F, 0});
  turn_inside_out(room);
  scene.objects.push_back({room, 1, {}});
  scene.lights.push_back({{-0.5F, 3, -0.5F}, {1, 0, 0}, {0, 0, 1}, {10, 10, 10}});
  scene.camera = simple_camera({0, 2, 2.5F}, {0, 0, 0}, 0.4F, 16);
  const Frame frame = rendered(PreparedScene(scene), 8);
  double total = 0;
  for (int s = 0; s < frame.spp; ++s)
    for (size_t i = 0; i < 3 * frame.plane_size(); ++i) {
      EXPECT_EQ(frame.plane(s, kDirectOffset)[i], frame.plane(s, 0)[i]);
      EXPECT_EQ(frame.plane(s, kIndirectOffset)[i], 0);
      total += frame.plane(s, 0)[i];
    }
  EXPECT_GT(total, 100);
}

TEST(ObjectIds, AreDistinctAndThoseOfTheObjects) {
  const Scene scene = open_room(grey(0.7F));
  const PreparedScene room(scene);
  const Frame frame = rendered(room, 1);
  std::map<float, int> seen;
  for (size_t p = 0; p < frame.plane_size(); ++p) {
    const float id = frame.plane(0, kIdOffset)[p];
    ++seen[id];
    EXPECT_EQ(id == 0, frame.plane(0, kDepthOffset)[p] >= kEscapedDepth);
    EXPECT_LE(id, static_cast<float>(scene.objects.size() + scene.lights.size()));
  }
  EXPECT_GE(seen.size(), 8u) << "sky, wall, ground, ball, four models, the lamp";
  // One by one: the id is the object that the ray from the camera meets.
  for (int y = 2; y < 24; y += 5)
    for (int x = 1; x < 24; x += 5) {
      const CameraSample where = {static_cast<float>(x), static_cast<float>(y), {}, 0};
      SampleNumbers numbers(RandomStream(1, RandomPurpose::test));
      const auto values = trace_sample(room, where, numbers, {});
      const auto hit = room.trace(room.scene().camera.ray(where), 0);
      const int expected = !hit               ? 0
                           : hit->object >= 0 ? 1 + hit->object
                                              : 1 + static_cast<int>(scene.objects.size()) + hit->light;
      EXPECT_EQ(values[kIdOffset], static_cast<float>(expected));
    }
}

/// A wall at depth 10 ahead and a camera that was somewhere else in the frame before.
std::array<float, kAllChannels> before_a_wall(const Camera& now, const CameraPose& before, float x, float y) {
  Scene scene;
  scene.materials = {plain_material(MaterialKind::diffuse, grey(0.5F))};
  scene.objects.push_back({make_parallelogram({-50, -50, -10}, {100, 0, 0}, {0, 100, 0}), 0, {}});
  scene.sky = constant_sky(1);
  scene.camera = now;
  scene.camera.previous = before;
  SampleNumbers numbers(RandomStream(1, RandomPurpose::test));
  return trace_sample(PreparedScene(scene), {x, y, {}, 0}, numbers, {});
}

TEST(FlowDepth, OfADollyIsItsWay) {
  const Camera now =
      simple_camera({0, 0, 0}, {0, 0, -1}, 2 * std::atan(0.5F), 64);  // 64 pixels a unit at depth 1
  const auto v = before_a_wall(now, {{0, 0, 1.5F}, now.axes}, 48, 24);
  EXPECT_NEAR(v[kFlowDepthOffset], 1.5, 1e-5) << "the wall was further away";
  EXPECT_NEAR(v[kDepthOffset] + v[kFlowDepthOffset], 11.5, 1e-5);
  // And flow shrinks the picture towards its middle by 10 / 11.5.
  EXPECT_NEAR(v[kFlowOffset], 16 * (10 / 11.5 - 1), 1e-4);
  EXPECT_NEAR(v[kFlowOffset + 1], -8 * (10 / 11.5 - 1), 1e-4);
}

TEST(FlowDepth, OfATurningCameraIsThePointsOldDepth) {
  const Camera now = simple_camera({0, 0, 0}, {0, 0, -1}, 2 * std::atan(0.5F), 64);
  const float angle = 0.2F;
  CameraPose before = {{}, now.axes};  // looked to the left by the angle: about +y
  before.axes.x = rotate(now.axes.x, {0, 1, 0}, angle);
  before.axes.z = rotate(now.axes.z, {0, 1, 0}, angle);
  const auto v = before_a_wall(now, before, 48, 32);
  // The point is (2.5, 0, -10); turned back by the angle its depth is 10 cos - 2.5 sin.
  const double then = 10 * std::cos(0.2) - 2.5 * std::sin(0.2),
               across = 2.5 * std::cos(0.2) + 10 * std::sin(0.2);
  EXPECT_NEAR(v[kFlowDepthOffset], then - 10, 1e-4);
  EXPECT_NEAR(v[kFlowOffset], 64 * across / then - 16, 1e-3);
}

TEST(FlowDepth, OfAMovingObjectIsItsWay) {
  Scene scene;
  scene.materials = {plain_material(MaterialKind::diffuse, grey(0.5F))};
  scene.objects.push_back(
      {make_parallelogram({-50, -50, -10}, {100, 0, 0}, {0, 100, 0}), 0, {}, Vec3{0, 0, -3}});
  scene.sky = constant_sky(1);
  scene.camera = simple_camera({0, 0, 0}, {0, 0, -1}, 1, 64);
  SampleNumbers numbers(RandomStream(1, RandomPurpose::test));
  auto v = trace_sample(PreparedScene(scene), {40, 20, {}, 0}, numbers, {});
  EXPECT_NEAR(v[kFlowDepthOffset], 3, 1e-5) << "it comes closer";
  scene.cut = true;
  v = trace_sample(PreparedScene(scene), {40, 20, {}, 0}, numbers, {});
  EXPECT_EQ(v[kFlowOffset], kNoFlow);
  EXPECT_EQ(v[kFlowOffset + 1], kNoFlow);
  EXPECT_EQ(v[kFlowDepthOffset], 0);
}

TEST(CameraOfAFrame, ProjectsASampleToItsPlace) {
  Scene scene = open_room(grey(0.7F));
  scene.camera.position = {0.3F, -0.2F, 0.5F};
  scene.camera.axes = look_at(scene.camera.position, {0.1F, 0.2F, -4}, {0, 1, 0}, 0.3F);
  scene.camera.width = 30;
  scene.camera.lens_radius = 0;
  const PreparedScene room(scene);
  const Frame frame = rendered(room, 1);
  ASSERT_TRUE(frame.info.world_to_camera && frame.info.world_to_ndc);
  const Matrix4 to_world = camera_to_world(*frame.info.world_to_camera);
  int hits = 0;
  for (int y = 1; y < 24; y += 3)
    for (int x = 2; x < 30; x += 3) {
      const CameraSample where = {static_cast<float>(x) + 0.3F, static_cast<float>(y) + 0.6F, {}, 0};
      const auto hit = room.trace(scene.camera.ray(where), 0);
      if (!hit) continue;
      ++hits;
      const auto ndc =
          project_to_ndc(*frame.info.world_to_ndc, {hit->position.x, hit->position.y, hit->position.z});
      EXPECT_NEAR(ndc[0] * 30, where.x, 2e-3);
      EXPECT_NEAR(ndc[1] * 24, where.y, 2e-3);
      // From depth and place alone, as a reader has them.
      SampleNumbers numbers(RandomStream(1, RandomPurpose::test));
      const float depth = trace_sample(room, where, numbers, {})[kDepthOffset],
                  focal = scene.camera.focal_pixels();
      const double view[4] = {(where.x - 15) / focal * depth, (12 - where.y) / focal * depth, -depth, 1};
      const float found[3] = {hit->position.x, hit->position.y, hit->position.z};
      for (size_t i = 0; i < 3; ++i) {
        double sum = 0;
        for (size_t k = 0; k < 4; ++k) sum += to_world[4 * i + k] * view[k];
        EXPECT_NEAR(sum, found[i], 1e-4);
      }
    }
  EXPECT_GT(hits, 30);
}

TEST(FilterGuidesOfFrames, ChangeNothingElse) {
  const PreparedScene room(open_room(grey(0.7F)));
  const Frame with = rendered(room, 2);
  RenderSettings settings;
  settings.seed = 3;
  settings.spp = 2;
  const Frame without = *render_samples(room, settings);
  EXPECT_EQ(without.channels, kSampleChannels);
  EXPECT_EQ(without.features, mh20_feature_names());
  EXPECT_FALSE(without.info.world_to_camera);
  for (int s = 0; s < 2; ++s)
    for (int c = 0; c < kSampleChannels; ++c)
      for (size_t p = 0; p < with.plane_size(); ++p) ASSERT_EQ(with.plane(s, c)[p], without.plane(s, c)[p]);
}

}  // namespace
}  // namespace ld
