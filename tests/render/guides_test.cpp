// The guides of every sample against closed forms, signs included, and against the mirrored and turned scene.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "frame/frame.h"
#include "tests/render/test_scenes.h"
#include "tests/support/flip_scene.h"

namespace ld {
namespace {

// Channels, written out so that a reordering of the schema is noticed here.
enum Channel {
  kNormalX = 3,
  kNormalY,
  kNormalZ,
  kDepth,
  kAlbedo,
  kSpecular = 10,
  kRoughness = 13,
  kMotionX,
  kMotionY,
  kCoc,
  kLensX,
  kLensY,
  kTime,
  kFlowX,
  kFlowY
};

/// A ball of radius 1 at depth 5 and a wall at depth 8, the camera at the origin looking along -z.
Scene ball_and_wall() {
  Scene scene;
  Mesh ball = make_sphere(6);
  place(ball, grey(1), {}, {0, 0, -5});
  scene.objects.push_back({ball, 0, {}});
  scene.objects.push_back({make_parallelogram({-20, -20, -8}, {40, 0, 0}, {0, 40, 0}), 1, {}});
  scene.materials = {plain_material(MaterialKind::diffuse, {0.8F, 0.4F, 0.2F}),
                     plain_material(MaterialKind::rough_conductor, {0.9F, 0.7F, 0.3F}, 0.5F)};
  scene.camera = simple_camera({0, 0, 0}, {0, 0, -1}, 2 * std::atan(0.5F), 64);  // focal length 64 pixels
  return scene;
}

std::array<float, kAllChannels> sample_at(const Scene& scene, const CameraSample& where) {
  const PreparedScene prepared(scene);
  SampleNumbers numbers(RandomStream(1, RandomPurpose::test));
  return trace_sample(prepared, where, numbers, {});
}

TEST(Guides, DepthAndNormalOfABall) {
  const Scene scene = ball_and_wall();
  // Through pixel (40, 26): view direction (8, 6, -64) / 64, up to the right.
  const auto v = sample_at(scene, {40, 26, {}, 0});
  const double dx = 8.0 / 64, dy = 6.0 / 64;
  // |t d - c| = 1 with c = (0, 0, -5), d = (dx, dy, -1): t is the depth.
  const double a = dx * dx + dy * dy + 1, b = 5, c = 24, t = (b - std::sqrt(b * b - a * c)) / a;
  EXPECT_NEAR(v[kDepth], t, 2e-3);
  EXPECT_NEAR(v[kNormalX], t * dx, 2e-3);
  EXPECT_NEAR(v[kNormalY], t * dy, 2e-3);
  EXPECT_NEAR(v[kNormalZ], 5 - t, 2e-3);
  EXPECT_GT(v[kNormalX], 0.1) << "right of the centre the normal points right";
  EXPECT_GT(v[kNormalY], 0.1) << "above the centre it points up";
  EXPECT_GT(v[kNormalZ], 0.5) << "and towards the camera";
}

TEST(Guides, MaterialOfTheFirstHit) {
  Scene scene = ball_and_wall();
  const CameraSample centre = {32, 32, {}, 0}, beside = {2, 2, {}, 0};
  auto v = sample_at(scene, centre);
  EXPECT_FLOAT_EQ(v[kAlbedo], 0.8F);
  EXPECT_FLOAT_EQ(v[kAlbedo + 2], 0.2F);
  EXPECT_EQ(v[kSpecular], 0);
  EXPECT_EQ(v[kRoughness], 1);
  v = sample_at(scene, beside);
  EXPECT_EQ(v[kAlbedo], 0);
  EXPECT_FLOAT_EQ(v[kSpecular], 0.9F);
  EXPECT_FLOAT_EQ(v[kSpecular + 2], 0.3F);
  EXPECT_FLOAT_EQ(v[kRoughness], 0.5F);
  EXPECT_FLOAT_EQ(v[kDepth], 8) << "along the axis, not along the ray";
  EXPECT_NEAR(v[kNormalZ], 1, 1e-6);
  scene.materials[0] = plain_material(MaterialKind::smooth_dielectric, {1, 0.5F, 1}, 0);
  v = sample_at(scene, centre);
  EXPECT_FLOAT_EQ(v[kAlbedo + 1], 0.5F);
  EXPECT_NEAR(v[kSpecular], 0.04, 1e-6);
  EXPECT_EQ(v[kRoughness], 0);
}

TEST(Guides, SurfacesSeenFromBehindFaceTheViewer) {
  Scene scene = ball_and_wall();
  turn_inside_out(scene.objects[1].mesh);
  EXPECT_NEAR(sample_at(scene, {2, 2, {}, 0})[kNormalZ], 1, 1e-6);
}

TEST(Guides, EscapedRays) {
  Scene scene = ball_and_wall();
  scene.objects.pop_back();
  scene.camera.lens_radius = 0.2F;
  scene.camera.focus_distance = 4;
  const auto v = sample_at(scene, {2, 2, {0.5F, -0.25F}, 0});
  EXPECT_EQ(v[kDepth], kEscapedDepth);
  for (int c = kNormalX; c <= kNormalZ; ++c) EXPECT_EQ(v[static_cast<size_t>(c)], 0);
  for (int c = kAlbedo; c <= kMotionY; ++c) EXPECT_EQ(v[static_cast<size_t>(c)], 0);
  EXPECT_NEAR(v[kCoc], 0.2 / 4 * 64, 1e-4);
  EXPECT_EQ(v[kLensX], 0.5F);
  EXPECT_EQ(v[kLensY], -0.25F);
}

TEST(Guides, CircleOfConfusionIsWhereTheRaysLand) {
  Scene scene = ball_and_wall();
  scene.camera.lens_radius = 0.25F;
  scene.camera.focus_distance = 6;
  // Closed form: R |d - f| / d on the focal plane, which 64 / f pixels a unit make pixels.
  EXPECT_NEAR(sample_at(scene, {2, 2, {}, 0})[kCoc], 0.25 * (8 - 6) / 8 / 6 * 64, 1e-4) << "behind: positive";
  EXPECT_NEAR(sample_at(scene, {32, 32, {}, 0})[kCoc], 0.25 * (4 - 6) / 4.0 / 6 * 64, 1e-3)
      << "in front: negative";
  // And as the rays have it: the pixels through which the lens' rim sees one point lie coc away from its
  // projection. Behind the focal plane the picture of the lens is upright: the rim's right sees the point
  // further right.
  const Vec3 point = {0.5F, -0.3F, -8};
  const Vec2 pixel = scene.camera.project(point);
  const float coc = scene.camera.circle_of_confusion(8);
  for (const Vec2 lens : {Vec2{1, 0}, Vec2{0, 1}, Vec2{-0.6F, 0.8F}}) {
    const Ray ray = scene.camera.ray({pixel.x + coc * lens.x, pixel.y - coc * lens.y, lens, 0});
    const Vec3 hit = ray.origin + ray.direction * ((point.z - ray.origin.z) / ray.direction.z);
    EXPECT_NEAR(hit.x, point.x, 1e-4);
    EXPECT_NEAR(hit.y, point.y, 1e-4);
    EXPECT_NEAR(ray.origin.x, 0.25F * lens.x, 1e-6) << "lens +x is right";
    EXPECT_NEAR(ray.origin.y, 0.25F * lens.y, 1e-6) << "lens +y is up";
  }
}

TEST(Guides, MotionIsInPixelsRightAndDown) {
  Scene scene = ball_and_wall();
  scene.camera.shutter = true;
  scene.objects[1].motion.translation = {0.5F, 0.25F, 0};  // right and up, at depth 8: 64 / 8 pixels a unit
  auto v = sample_at(scene, {2, 2, {}, 0.3F});
  EXPECT_NEAR(v[kMotionX], 4, 1e-3);
  EXPECT_NEAR(v[kMotionY], -2, 1e-3);
  EXPECT_EQ(v[kTime], 0.3F);
  // Away from the camera: the point that is seen at time t at pixel offset o came from o d(t) / 8 and goes to
  // o d(t) / 10.
  scene.objects[1].motion.translation = {0, 0, -2};
  v = sample_at(scene, {12, 52, {}, 0.5F});
  EXPECT_NEAR(v[kDepth], 9, 1e-4);
  EXPECT_NEAR(v[kMotionX], -20 * 9 * (1.0 / 10 - 1.0 / 8), 1e-3);
  EXPECT_NEAR(v[kMotionY], 20 * 9 * (1.0 / 10 - 1.0 / 8), 1e-3);
  // What stands still beside what moves has none, and an instant shutter shows none.
  EXPECT_EQ(sample_at(scene, {32, 32, {}, 0.5F})[kMotionX], 0);
  scene.camera.shutter = false;
  EXPECT_EQ(sample_at(scene, {12, 52, {}, 0})[kMotionX], 0);
}

TEST(Guides, MovingObjectsStandWhereTheirTimeSays) {
  Scene scene = ball_and_wall();
  scene.camera.shutter = true;
  scene.objects[0].motion.translation = {0, 0, 2};
  for (const float time : {0.0F, 0.25F, 1.0F})
    EXPECT_NEAR(sample_at(scene, {32, 32, {}, time})[kDepth], 4 - 2 * time, 2e-3);
}

TEST(Guides, DrawnSamplesFillPixelLensAndShutter) {
  Camera camera = ball_and_wall().camera;
  SampleNumbers numbers(RandomStream(3, RandomPurpose::test));
  CameraSample sample = draw_camera_sample(camera, 5, 9, numbers);
  EXPECT_EQ(sample.lens.x, 0) << "a pinhole has no lens positions";
  EXPECT_EQ(sample.time, 0) << "an instant shutter has no times";
  camera.lens_radius = 0.1F;
  camera.shutter = true;
  double x = 0, y = 0, lens_x = 0, lens_y = 0, radius2 = 0, time = 0, time2 = 0;
  constexpr int kDraws = 20000;
  for (int k = 0; k < kDraws; ++k) {
    sample = draw_camera_sample(camera, 5, 9, numbers);
    ASSERT_TRUE(sample.x >= 5 && sample.x <= 6 && sample.y >= 9 && sample.y <= 10);
    const double r2 = sample.lens.x * sample.lens.x + sample.lens.y * sample.lens.y;
    ASSERT_LE(r2, 1.00001);
    ASSERT_TRUE(sample.time >= 0 && sample.time <= 1);
    x += sample.x - 5, y += sample.y - 9, lens_x += sample.lens.x, lens_y += sample.lens.y;
    radius2 += r2, time += sample.time, time2 += sample.time * sample.time;
  }
  // Five standard errors of uniform numbers (deviation 0.29) and of disk coordinates (0.5).
  EXPECT_NEAR(x / kDraws, 0.5, 0.0103);
  EXPECT_NEAR(y / kDraws, 0.5, 0.0103);
  EXPECT_NEAR(lens_x / kDraws, 0, 0.018);
  EXPECT_NEAR(lens_y / kDraws, 0, 0.018);
  EXPECT_NEAR(radius2 / kDraws, 0.5, 0.0103) << "uniform by area";
  EXPECT_NEAR(time / kDraws, 0.5, 0.0103);
  EXPECT_NEAR(time2 / kDraws, 1.0 / 3, 0.0106);
}

/// A frame moved and turned as an augmentation would: written here on its own, from the schema's table.
Frame turn_frame(const Frame& frame, const Turn& turn) {
  Frame result(frame.width, frame.height, frame.spp);
  const int last = frame.width - 1;
  for (int s = 0; s < frame.spp; ++s)
    for (int y = 0; y <= last; ++y)
      for (int x = 0; x <= last; ++x) {
        int tx = turn.flip_x ? last - x : x, ty = turn.flip_y ? last - y : y;
        for (int k = 0; k < turn.quarter_turns; ++k) {
          const int old_x = tx;  // counterclockwise: what was on the right edge comes to the top
          tx = ty;
          ty = last - old_x;
        }
        const size_t from =
            static_cast<size_t>(y) * static_cast<size_t>(frame.width) + static_cast<size_t>(x);
        const size_t to =
            static_cast<size_t>(ty) * static_cast<size_t>(frame.width) + static_cast<size_t>(tx);
        for (int c = 0; c < kSampleChannels; ++c) result.plane(s, c)[to] = frame.plane(s, c)[from];
        const auto turn_pair = [&](int cx, int cy, float up) {
          const Vec3 v = turn({frame.plane(s, cx)[from], up * frame.plane(s, cy)[from], 0});
          result.plane(s, cx)[to] = v.x;
          result.plane(s, cy)[to] = up * v.y;
        };
        turn_pair(kNormalX, kNormalY, 1);
        turn_pair(kMotionX, kMotionY, -1);
        turn_pair(kLensX, kLensY, 1);
        turn_pair(kFlowX, kFlowY, -1);
      }
  return result;
}

TEST(Guides, TurnedFrameEqualsFrameOfTurnedScene) {
  constexpr int kSize = 32, kSpp = 4;
  const Frame upright = turned_frame({}, kSize, kSpp);
  // The scene must have something to turn in every channel.
  for (int c = 0; c < kSampleChannels; ++c) {
    float largest = 0;
    for (int s = 0; s < kSpp; ++s)
      for (size_t p = 0; p < upright.plane_size(); ++p)
        largest = std::max(largest, std::abs(upright.plane(s, c)[p]));
    EXPECT_GT(largest, 0.04F) << "channel " << c;
  }
  for (const Turn turn : {Turn{}, Turn{true, false, 0}, Turn{false, true, 0}, Turn{false, false, 1},
                          Turn{false, false, 2}, Turn{true, false, 1}, Turn{true, true, 3}}) {
    SCOPED_TRACE(
        fmt::format("flip x {}, flip y {}, {} quarter turns", turn.flip_x, turn.flip_y, turn.quarter_turns));
    const Frame expected = turned_frame(turn, kSize, kSpp);
    // Rays that graze a silhouette may round to the other side of it.
    EXPECT_LE(differing_samples(turn_frame(upright, turn), expected, 1e-3F), kSize * kSize * kSpp / 500);
    if (turn.flip_x || turn.flip_y || turn.quarter_turns != 0) {
      EXPECT_GT(differing_samples(upright, expected, 1e-3F), kSize * kSize * kSpp / 2)
          << "the turn changed nothing";
    }
  }
}

}  // namespace
}  // namespace ld
