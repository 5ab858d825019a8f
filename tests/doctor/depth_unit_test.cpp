// Depths in other units, cut off, and through mirrors; features when only some frames are read.
#include <gtest/gtest.h>

#include "render/trace/image_renderer.h"
#include "tests/doctor/pictures.h"
#include "tests/render/test_scenes.h"

namespace ld {
namespace {

class DepthUnit : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    const TemporaryFolder folder;
    good_ = new Pictures(render_pictures(folder.path()));
  }
  static void TearDownTestSuite() { delete good_; }

  /// The good pictures with these depths; `scale`: the file's, 0 for that of its depths.
  static std::string findings(const std::function<float(float)>& depth, bool keep_scale) {
    Pictures pictures = *good_;
    for (Picture& picture : pictures) {
      change_samples(picture.frame, kDepthOffset, 1,
                     [&](const Frame&, int, int, float* value) { *value = depth(*value); });
      if (!keep_scale) picture.frame.info.depth_scale = 0;
    }
    return text_of(examine(pictures));
  }
  static void expect(const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << "expected '" << part << "' in:\n" << text;
  }

  static Pictures* good_;
};
Pictures* DepthUnit::good_ = nullptr;

TEST_F(DepthUnit, MillimetresBelowTheEndOfHalfFloats) {
  const auto millimetres = [](float depth) { return std::min(1000 * depth, 65000.0F); };
  const std::string kept = findings(millimetres, true), own = findings(millimetres, false);
  expect(kept, "problem: depth: ldDepthScale is in another unit than the depths of 8 of 8 frames");
  expect(kept, "problem: depth: rays that escaped (no normal) have a depth other than 65504");
  expect(own, "warning: depth: half of the depths of 8 of 8 frames");
  EXPECT_EQ(own.find("ldDepthScale"), std::string::npos) << own;
  // Only what was hit, so that what escaped is as it should be.
  const std::string hits =
      findings([&](float depth) { return depth < kEscapedDepth ? millimetres(depth) : depth; }, false);
  expect(hits, "warning: depth: half of the depths of 8 of 8 frames");
}

TEST_F(DepthUnit, DepthsThatAreCutOff) {
  const std::string text =
      findings([](float depth) { return depth < kEscapedDepth ? std::min(depth, 4.0F) : depth; }, false);
  expect(text, "problem: depth: depths are cut off at the largest of their frame in samples of");
}

TEST_F(DepthUnit, AWallThatFacesTheCameraIsNotCutOff) {
  Evidence evidence;
  evidence.name = "wall";
  evidence.frame = (*good_)[0].frame;
  Frame& frame = evidence.frame;
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      const bool wall = p % 3 != 0;
      frame.plane(s, kDepthOffset)[p] = wall ? 7.0F : 2.0F + 0.001F * static_cast<float>(p);
      for (int c = 0; c < 3; ++c) frame.plane(s, kNormalOffset + c)[p] = c == 2 ? 1.0F : 0.0F;
    }
  frame.info.depth_scale = 7;
  complete(evidence);
  EXPECT_EQ(text_of(examine_frame(evidence)).find("cut off"), std::string::npos);
}

/// A room with a mirror that takes up most of the picture.
Scene mirror_room() {
  Scene scene;
  scene.objects = {{make_parallelogram({-6, -1, 6}, {12, 0, 0}, {0, 0, -12}), 0, {}},        // floor
                   {make_parallelogram({-6, 5, -6}, {12, 0, 0}, {0, 0, 12}), 0, {}},         // ceiling
                   {make_parallelogram({-6, -1, -6}, {12, 0, 0}, {0, 6, 0}), 0, {}},         // back wall
                   {make_parallelogram({6, -1, 6}, {-12, 0, 0}, {0, 6, 0}), 1, {}},          // front wall
                   {make_parallelogram({-6, -1, 6}, {0, 0, -12}, {0, 6, 0}), 1, {}},         // left
                   {make_parallelogram({6, -1, -6}, {0, 0, 12}, {0, 6, 0}), 0, {}},          // right
                   {make_parallelogram({-3, -0.8F, -4}, {6, 0, -1.5F}, {0, 5, 0}), 2, {}}};  // the mirror
  scene.materials = {plain_material(MaterialKind::diffuse, {0.7F, 0.7F, 0.6F}),
                     plain_material(MaterialKind::diffuse, {0.7F, 0.2F, 0.2F}),
                     plain_material(MaterialKind::mirror, {0.9F, 0.9F, 0.9F}, 0)};
  scene.lights.push_back({{-1, 4.9F, -1}, {2, 0, 0}, {0, 0, 2}, grey(8)});
  scene.camera = simple_camera({0.5F, 1.5F, 3}, {0, 1.2F, -4}, 0.9F, 96);
  return scene;
}

TEST(DoctorOfMirrors, WhatMirrorsShowIsASceneLikeAnyOther) {
  const PreparedScene prepared(mirror_room());
  RenderSettings settings;
  settings.spp = 8;
  settings.threads = 2;
  settings.path.guides_through_specular = true;
  Evidence evidence;
  evidence.name = "mirror";
  evidence.frame = *render_samples(prepared, settings);
  complete(evidence);
  const Diagnosis diagnosis = examine_frame(evidence);
  EXPECT_TRUE(diagnosis.findings.empty()) << text_of(diagnosis);
  EXPECT_EQ(diagnosis.facts["normals"]["facing_away"], 0);
  EXPECT_GT(diagnosis.facts["depth_axis"]["flat_surfaces"], 20);
  EXPECT_GT(diagnosis.facts["ranges"]["depth"]["max"].get<double>(), 14) << "behind the mirror";
}

TEST_F(DepthUnit, SomeFramesSayNotWhatAllNeed) {
  const TemporaryFolder folder;
  Pictures pictures = *good_;
  for (const size_t index : {0, 2, 5})  // those that are read when three are asked for
    for (const char* feature : {"motion", "coc"})
      change_samples(pictures[index].frame, find_feature(feature).offset, find_feature(feature).channels,
                     [](const Frame&, int, int, float* values) { std::fill_n(values, 3, 0.0F); });
  const Manifest manifest = write_pictures(folder.path(), pictures);
  const Diagnosis all = examine_dataset(folder.path(), manifest, {2, 0}),
                  some = examine_dataset(folder.path(), manifest, {2, 3});
  EXPECT_EQ(all.facts["features_auto"].size(), 10u);
  EXPECT_TRUE(some.facts["features_auto"].is_null()) << some.facts["features_auto"];
  EXPECT_EQ(some.facts["features_varying"].size(), 6u) << some.facts["features_varying"];
  EXPECT_EQ(text_of(some), "") << "what three frames lack is no reason to leave it out";
  // Where three frames show that everything varies, no other can change it.
  const Manifest good = write_pictures(folder.path(), *good_);
  EXPECT_EQ(examine_dataset(folder.path(), good, {2, 3}).facts["features_auto"], all.facts["features_auto"]);
}

}  // namespace
}  // namespace ld
