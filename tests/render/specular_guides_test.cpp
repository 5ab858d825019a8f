// Guides through mirrors and smooth glass: those of the virtual image, against closed forms.
#include <gtest/gtest.h>

#include "render/trace/guides.h"
#include "tests/render/test_scenes.h"

namespace ld {
namespace {

/// A camera at the origin that looks along -z, 64 pixels wide, focal length 64; a red wall at depth 8.
Scene red_wall() {
  Scene scene;
  scene.camera = simple_camera({0, 0, 0}, {0, 0, -1}, 2 * std::atan(0.5F), 64);
  scene.objects.push_back({make_parallelogram({-40, -40, -8}, {80, 0, 0}, {0, 80, 0}), 0, {}});
  scene.materials = {plain_material(MaterialKind::diffuse, {0.8F, 0.1F, 0.1F}),
                     plain_material(MaterialKind::mirror, {0.9F, 0.8F, 0.7F}, 0),
                     plain_material(MaterialKind::smooth_dielectric, {1, 1, 1}, 0)};
  return scene;
}

Guides guides_at(const Scene& scene, float x, float y, bool through = true) {
  const PreparedScene prepared(scene);
  SampleNumbers numbers(RandomStream(1, RandomPurpose::test));
  PathSettings settings;
  settings.guides_through_specular = through;
  Guides guides;
  trace_path(prepared, scene.camera.ray({x, y, {}, 0}), 0, numbers, settings, &guides);
  return guides;
}

/// A mirror at depth 4 that faces the camera and shows a red wall 10 behind it.
Scene facing_mirror() {
  Scene scene = red_wall();
  scene.objects[0].mesh = make_parallelogram({40, -40, 10}, {-80, 0, 0}, {0, 80, 0});
  scene.objects.push_back({make_parallelogram({-4, -4, -4}, {8, 0, 0}, {0, 8, 0}), 1, {}});
  return scene;
}

TEST(SpecularGuides, AMirrorShowsWhatLiesBehindTheCamera) {
  const Scene scene = facing_mirror();
  const Guides first = guides_at(scene, 20, 40, false), through = guides_at(scene, 20, 40);
  EXPECT_FLOAT_EQ(first.specular.y, 0.8F);
  EXPECT_EQ(first.albedo.x, 0);
  EXPECT_EQ(first.roughness, 0);
  EXPECT_FLOAT_EQ(first.depth, 4);
  EXPECT_NEAR(through.albedo.x, 0.8F * 0.9F, 1e-6);
  EXPECT_EQ(through.specular.x, 0);
  EXPECT_EQ(through.roughness, 1);
  EXPECT_NEAR(through.depth, 4 + 14, 1e-4) << "along the axis, from pixels beside it too";
  EXPECT_NEAR(through.normal.z, 1, 1e-6) << "the virtual wall faces the camera";
}

TEST(SpecularGuides, ATurnedMirrorShowsTheWallBesideItAsOneAhead) {
  Scene scene = red_wall();
  // Turned by 45 degrees at depth 4, it shows the wall at x = 6, whose image lies 4 + 6 ahead.
  scene.objects[0].mesh = make_parallelogram({6, -40, 40}, {0, 0, -80}, {0, 80, 0});
  scene.objects.push_back({make_parallelogram({-4, -4, 0}, {8, 0, -8}, {0, 8, 0}), 1, {}});
  for (const float x : {20.0F, 32.0F, 44.0F}) {
    const Guides guides = guides_at(scene, x, 40);
    EXPECT_NEAR(guides.albedo.x, 0.8F * 0.9F, 1e-6);
    EXPECT_NEAR(guides.depth, 10, 1e-3) << x;
    EXPECT_NEAR(guides.normal.z, 1, 1e-5) << x;
  }
}

TEST(SpecularGuides, TwoMirrorsTurnTheImageBack) {
  Scene scene = red_wall();
  // A periscope: up at depth 4 by a mirror turned by 45 degrees, ahead again 3 above, to the wall at depth 8.
  scene.objects.push_back({make_parallelogram({-2, -2, -2}, {4, 0, 0}, {0, 4, -4}), 1, {}});
  scene.objects.push_back({make_parallelogram({-9, 1, -2}, {18, 0, 0}, {0, 4, -4}), 1, {}});
  const Guides guides = guides_at(scene, 32, 32);
  EXPECT_NEAR(guides.albedo.x, 0.8F * 0.9F * 0.9F, 1e-6);
  EXPECT_NEAR(guides.depth, 4 + 3 + 4, 1e-3);
  EXPECT_NEAR(guides.normal.z, 1, 1e-5);
}

TEST(SpecularGuides, APaneOfGlassChangesLittle) {
  Scene scene = red_wall();
  scene.objects.push_back({make_parallelogram({-4, -4, -4}, {8, 0, 0}, {0, 8, 0}), 2, {}});
  scene.objects.push_back({make_parallelogram({4, -4, -4.2F}, {-8, 0, 0}, {0, 8, 0}), 2, {}});
  for (const float x : {12.0F, 32.0F}) {
    const Guides guides = guides_at(scene, x, 40);
    EXPECT_NEAR(guides.albedo.x, 0.8F, 1e-6) << "the sample goes through";
    EXPECT_NEAR(guides.depth, 8, 0.02);
    EXPECT_NEAR(guides.normal.z, 1, 1e-5);
  }
}

TEST(SpecularGuides, TheSkyInAMirrorIsAsFarAsTheSky) {
  Scene scene = facing_mirror();
  scene.objects.erase(scene.objects.begin());
  scene.camera.lens_radius = 0.25F;
  scene.camera.focus_distance = 6;
  const Guides guides = guides_at(scene, 32, 32);
  EXPECT_EQ(guides.depth, kEscapedDepth);
  EXPECT_EQ(guides.normal.z, 0);
  EXPECT_EQ(guides.albedo.x, 0);
  EXPECT_FLOAT_EQ(guides.coc, scene.camera.circle_of_confusion_at_infinity());
}

TEST(SpecularGuides, ALampInAMirror) {
  Scene scene = facing_mirror();
  scene.lights.push_back({{1, -1, 5}, {-2, 0, 0}, {0, 2, 0}, {2, 1, 1}});
  const Guides guides = guides_at(scene, 32, 32);
  EXPECT_NEAR(guides.depth, 4 + 9, 1e-4);
  EXPECT_NEAR(guides.normal.z, 1, 1e-6);
  EXPECT_NEAR(guides.albedo.y, 0.5F * 0.8F, 1e-6);
}

TEST(SpecularGuides, TheLensSeesTheImageInFocusAtItsOwnDepth) {
  Scene scene = facing_mirror();
  scene.camera.lens_radius = 0.25F;
  scene.camera.focus_distance = 18;
  EXPECT_NEAR(guides_at(scene, 32, 32).coc, 0, 1e-4);
  EXPECT_LT(guides_at(scene, 32, 32, false).coc, -2) << "the mirror itself is blurred";
}

TEST(SpecularGuides, MovementStaysThatOfTheFirstHit) {
  Scene scene = facing_mirror();
  scene.camera.shutter = true;
  scene.objects[1].motion.translation = {0.5F, 0, 0};  // at depth 4: 16 pixels a unit
  EXPECT_NEAR(guides_at(scene, 32, 32).motion.x, 8, 1e-3);
}

}  // namespace
}  // namespace ld
