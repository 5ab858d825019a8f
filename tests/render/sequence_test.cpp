// Sequences: objects and camera from frame to frame, and the flow that says where surface points were before.
#include "render/recipe/sequence.h"

#include <gtest/gtest.h>

#include "render/random/random_scene.h"
#include "render/recipe/scene_source.h"
#include "render/trace/path_tracer.h"

namespace ld {
namespace {

constexpr int kWidth = 48, kHeight = 32;

void expect_near(Vec3 a, Vec3 b, float tolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

/// A wall that stands, a box that turns as it moves and a ball that moves, seen by a camera that flies by.
SequencePlan turning_box() {
  Scene scene;
  scene.materials.resize(1);
  Object wall, box, ball;
  wall.mesh = make_parallelogram({-20, -20, -6}, {40, 0, 0}, {0, 40, 0});
  box.mesh = make_box();
  place(box.mesh, {1, 1, 1}, {}, {-1.2F, 0, 0});
  box.motion.translation = {0.1F, 0.05F, -0.02F};
  box.motion.axis = normalize({0.3F, 1, 0.2F});
  box.motion.angle = 0.15F;
  box.motion.pivot = {-1.2F, 0, 0};
  ball.mesh = make_sphere(3);
  place(ball.mesh, {1, 1, 1}, {}, {1.8F, 0, 0});
  ball.motion.translation = {0, -0.07F, 0.1F};
  scene.objects = {wall, box, ball};
  scene.sky = Sky();
  scene.camera.width = kWidth;
  scene.camera.height = kHeight;
  scene.camera.fov = 0.9F;
  std::vector<Vec3> places, targets;
  for (int i = 0; i < 6; ++i) {
    const auto t = static_cast<float>(i);
    places.push_back({-1 + 0.4F * t, 0.2F * t * t * 0.2F, 7 - 0.2F * t});
    targets.push_back({0.1F * t, -0.1F * t, 0});
  }
  return {std::move(scene), CameraPath(places, targets, {0, 1, 0}, 4)};
}

TEST(Sequence, PartsOfAMotionFollowOneAnother) {
  const Motion frame = turning_box().scene.objects[1].motion;
  const Vec3 start = {0.3F, -0.7F, 1.1F};
  Vec3 stepwise = start;
  for (int i = 0; i < 5; ++i) stepwise = part_of(frame, static_cast<float>(i), 1).point(stepwise, 1);
  const Vec3 at_once = part_of(frame, 0, 5).point(start, 1);
  expect_near(stepwise, at_once, 1e-5F);
  expect_near(part_of(frame, 5, -5).point(at_once, 1), start, 1e-5F);
  const Vec3 shutter = part_of(frame, 5, 0.5F).point(at_once, 1);
  expect_near(shutter, part_of(frame, 0, 5.5F).point(start, 1), 1e-5F);
}

TEST(Sequence, FlowLandsOnTheSameSurfacePoint) {
  const SequencePlan plan = turning_box();
  const PreparedScene before(sequence_frame(plan, 3, 0)), now(sequence_frame(plan, 4, 0));
  const Camera &camera = now.scene().camera, &old_camera = before.scene().camera;
  expect_near(camera.previous->position, old_camera.position, 1e-6F);
  int compared = 0, hidden = 0;
  std::vector<int> seen(3);
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const CameraSample where = {static_cast<float>(x) + 0.5F, static_cast<float>(y) + 0.5F, {}, 0};
      SampleNumbers numbers(RandomStream(1, RandomPurpose::test));
      const auto values = trace_sample(now, where, numbers, {});
      const Vec2 flow = {values[kFlowOffset], values[kFlowOffset + 1]};
      const auto hit = now.trace(camera.at(0).ray(where), 0);
      ASSERT_TRUE(hit);
      ++seen[static_cast<size_t>(hit->object)];

      // Closed form: the point back at frame 0, then on to frame 3.
      const Motion way = plan.scene.objects[static_cast<size_t>(hit->object)].motion;
      const Vec3 rest = part_of(way, 4, -4).point(hit->position, 1);
      const Vec3 then = part_of(way, 0, 3).point(rest, 1);
      const Vec2 landed = old_camera.at(0).project(then);
      EXPECT_NEAR(flow.x, landed.x - where.x, 2e-3F);
      EXPECT_NEAR(flow.y, landed.y - where.y, 2e-3F);

      // And by looking: a ray of the frame before through that place finds the point, unless something hid
      // it.
      const auto found = before.trace(old_camera.at(0).ray({where.x + flow.x, where.y + flow.y, {}, 0}), 0);
      ASSERT_TRUE(found);
      if (found->object != hit->object || length(found->texture.position - rest) > 0.02F) {
        ++hidden;
        continue;
      }
      ++compared;
    }
  EXPECT_GT(std::min({seen[0], seen[1], seen[2]}), 40) << "all three are in the picture";
  EXPECT_GT(compared, 19 * hidden);
  EXPECT_GT(hidden, 0) << "something always comes out from behind";
}

TEST(Sequence, TexturesStickToMovingObjects) {
  const SequencePlan plan = turning_box();
  for (const int64_t position : {0, 7}) {
    const Scene scene = sequence_frame(plan, position, 0.5F);
    for (size_t i = 0; i < scene.objects.size(); ++i)
      for (size_t v = 0; v < scene.objects[i].mesh.positions.size(); v += 5)
        expect_near(scene.objects[i].texture.point(scene.objects[i].mesh.positions[v], 1),
                    plan.scene.objects[i].mesh.positions[v], 1e-4F);
  }
}

TEST(Sequence, ShutterIsAShareOfTheWayToTheNextFrame) {
  const SequencePlan plan = turning_box();
  const Scene open = sequence_frame(plan, 2, 0.5F), instant = sequence_frame(plan, 2, 0);
  const Vec3 corner = open.objects[1].mesh.positions[0], rest = plan.scene.objects[1].mesh.positions[0];
  expect_near(open.objects[1].motion.point(corner, 1),
              part_of(plan.scene.objects[1].motion, 0, 2.5F).point(rest, 1), 1e-5F);
  expect_near(open.camera.close->position, plan.path.at(2.5F).position, 1e-6F);
  EXPECT_TRUE(open.camera.shutter);
  EXPECT_FALSE(instant.camera.shutter);
  EXPECT_FALSE(instant.camera.close.has_value());
  EXPECT_TRUE(instant.objects[1].motion.still());
  EXPECT_FALSE(instant.objects[1].previous.still());
}

TEST(Sequence, CameraFliesSmoothlyAndTouchesNothing) {
  SceneConfig config;
  config.variety = "simple";
  config.objects = {10, 14};
  constexpr int64_t kLength = 24;
  int moving = 0;
  for (uint32_t seed = 0; seed < 6; ++seed) {
    Scene scene = prepare_random_scene(config, seed, seed, kWidth, kHeight)->scene();
    const Camera start = scene.camera.at(0);
    const float distance = scene.camera.focus_distance;
    RandomStream random(seed, RandomPurpose::test);
    const SequencePlan plan = plan_sequence(std::move(scene), distance, kLength, 1, random);
    expect_near(plan.path.at(0).position, start.position, 1e-5F);
    float longest = 0;
    for (int64_t k = 0; k < kLength; ++k) {
      const auto frame = static_cast<float>(k);
      const CameraPose a = plan.path.at(frame - 1), b = plan.path.at(frame), c = plan.path.at(frame + 1);
      const Vec3 step = c.position - b.position, bend = c.position - 2 * b.position + a.position;
      longest = std::max(longest, length(step));
      EXPECT_LE(length(step), 0.05F * distance) << "seed " << seed << " frame " << k;
      EXPECT_LE(length(bend), 0.006F * distance) << "seed " << seed << " frame " << k;
      EXPECT_GT(dot(b.axes.z, c.axes.z), 0.99F);
      if (k % 6 != 0 || length(step) == 0) continue;
      const PreparedScene prepared(sequence_frame(plan, k, 0));
      const auto hit = prepared.trace({b.position, normalize(step)}, 0);
      EXPECT_TRUE(!hit || hit->distance > length(step)) << "seed " << seed << " frame " << k;
    }
    if (longest > 0.002F * distance) ++moving;
  }
  EXPECT_GE(moving, 5) << "standing still is the last resort";
}

TEST(Sequence, FramesOfARecipeFollowOneAnother) {
  Recipe recipe;
  recipe.resolution = {kWidth, kHeight};
  recipe.sequence.length = 4;
  recipe.scenes.variety = "simple";
  recipe.scenes.objects = {6, 8};
  const auto source = make_scene_source(recipe);
  const auto first = source->prepare(4), second = source->prepare(5), other = source->prepare(8);
  expect_near(second->scene().camera.previous->position, first->scene().camera.position, 1e-6F);
  EXPECT_EQ(first->scene().objects.size(), second->scene().objects.size());
  EXPECT_GT(length(other->scene().camera.position - second->scene().camera.position), 0.1F);
  // Another source, asked for the second frame only, says the same.
  const auto again = make_scene_source(recipe)->prepare(5);
  EXPECT_EQ(again->scene().camera.position.x, second->scene().camera.position.x);
  EXPECT_EQ(again->scene().objects.back().mesh.positions[0].x,
            second->scene().objects.back().mesh.positions[0].x);
}

}  // namespace
}  // namespace ld
