// The presets on files that the renderers themselves wrote (tests/fixtures/import, made by
// scripts/peers/import_fixtures.py; the README.md there has the values that follow from the scene).

#include <gtest/gtest.h>

#include "frame/frame_file.h"
#include "frame/frame_pair.h"
#include "import/frame_import.h"
#include "tests/support/expect_error.h"
#include "tests/support/exr_parts.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

std::vector<fs::path> samples(const std::string& renderer, int count) {
  std::vector<fs::path> files;
  for (int s = 0; s < count; ++s)
    files.push_back(kImportFixtures / renderer / ("sample_0" + std::to_string(s) + ".exr"));
  return files;
}

ImportedFrame import_with(const std::string& preset, const std::vector<fs::path>& files,
                          const std::vector<std::string>& assignments = {}) {
  const std::string folder = preset == "mitsuba" ? "mitsuba" : "cycles";
  return import_frame(files, read_mapping(preset, "", assignments),
                      read_camera(kImportFixtures / folder / "camera.yaml"), false);
}

struct Expected {
  int x, y;
  std::vector<float> normal, albedo;
  float depth;
};

/// The table of the READMEs.
const Expected kPlane{1, 8, {0.36F, 0.48F, 0.8F}, {0.5F, 0.3F, 0.2F}, 4.3649F};
const Expected kSphere{5, 3, {0.2440F, 0.0893F, 0.9656F}, {0.2F, 0.6F, 0.4F}, 2.5655F};
const Expected kMetal{6, 9, {0.3043F, 0.0910F, 0.9482F}, {0, 0, 0}, 2.6681F};
const size_t kSky = 6 * 16 + 14;

std::vector<float> values(const Frame& frame, int sample, const std::string& name, int x, int y) {
  const Feature& feature = find_feature(name);
  std::vector<float> result;
  for (int c = 0; c < feature.channels; ++c)
    result.push_back(frame.plane(sample, feature.offset + c)[y * frame.width + x]);
  return result;
}

void expect_near(const std::vector<float>& found, const std::vector<float>& expected, float tolerance) {
  ASSERT_EQ(found.size(), expected.size());
  for (size_t c = 0; c < found.size(); ++c)
    EXPECT_NEAR(found[c], expected[c], tolerance) << "component " << c;
}

void expect_surface(const Frame& frame, int sample, const Expected& expected, float tolerance) {
  SCOPED_TRACE("sample " + std::to_string(sample) + ", pixel " + std::to_string(expected.x));
  expect_near(values(frame, sample, "normal", expected.x, expected.y), expected.normal, tolerance);
  expect_near(values(frame, sample, "depth", expected.x, expected.y), {expected.depth}, tolerance);
}

TEST(CyclesPreset, FindsTheSceneThatWasRendered) {
  const ImportedFrame imported = import_with("cycles", samples("cycles", 4));
  const Frame& frame = imported.frame;
  EXPECT_EQ(frame.width, 16);
  EXPECT_EQ(frame.height, 12);
  EXPECT_EQ(frame.spp, 4);
  EXPECT_EQ(frame.features,
            (std::vector<std::string>{"radiance", "normal", "depth", "albedo", "specular", "flow"}));
  EXPECT_FALSE(imported.faults.any());
  for (int s = 0; s < 4; ++s) {
    for (const Expected& expected : {kPlane, kSphere, kMetal}) {
      expect_surface(frame, s, expected, 2e-3F);  // spheres are meshes
      expect_near(values(frame, s, "albedo", expected.x, expected.y), expected.albedo, 1e-3F);
    }
    expect_near(values(frame, s, "specular", kMetal.x, kMetal.y), {0.9F, 0.7F, 0.3F}, 1e-3F);
    expect_near(values(frame, s, "specular", kPlane.x, kPlane.y), {0, 0, 0}, 1e-3F);
    expect_near(values(frame, s, "radiance", 14, 6), {0.8F, 1.0F, 1.5F}, 1e-3F);
    EXPECT_EQ(frame.plane(s, kDepthOffset)[kSky], kEscapedDepth);
    expect_near(values(frame, s, "normal", 14, 6), {0, 0, 0}, 0);
  }
  EXPECT_EQ(frame.alpha, std::vector<float>(frame.valid.size(), 1));
}

TEST(CyclesPreset, VectorsLeadToThePreviousFrame) {
  const Frame frame = import_with("cycles", {kImportFixtures / "cycles/moving.exr"}).frame;
  // The metal sphere moves right and up by (0.6161, 0.3696) pixels a frame.
  expect_near(values(frame, 0, "flow", kMetal.x, kMetal.y), {-0.6161F, 0.3696F}, 1e-3F);
  expect_near(values(frame, 0, "flow", kPlane.x, kPlane.y), {0, 0}, 1e-3F);
}

TEST(CyclesPreset, WhatAFileLacksIsAbsent) {
  const Frame frame = import_with("cycles", {kImportFixtures / "cycles/no_vector.exr"}).frame;
  EXPECT_EQ(frame.features, (std::vector<std::string>{"radiance", "normal", "depth", "albedo", "specular"}));
  EXPECT_ERROR(import_with("cycles",
                           {kImportFixtures / "cycles/moving.exr", kImportFixtures / "cycles/no_vector.exr"}),
               "expected the same in all samples");
}

TEST(CyclesPreset, AlphaOfATransparentFilm) {
  const Frame frame = import_with("cycles", {kImportFixtures / "cycles/transparent_sky.exr"}).frame;
  ASSERT_EQ(frame.alpha.size(), 192u);
  EXPECT_EQ(frame.alpha[kSky], 0);
  EXPECT_EQ(frame.alpha[static_cast<size_t>(kPlane.y) * 16 + kPlane.x], 1);
  expect_near(values(frame, 0, "radiance", 14, 6), {0, 0, 0}, 0);
}

TEST(CyclesPreset, HalfFloatsAndPartsForPassesHoldTheSame) {
  const Frame half_floats = import_with("cycles", {kImportFixtures / "cycles/half.exr"}).frame;
  const ImportedFrame blender5 = import_with("cycles", samples("cycles5", 2));
  EXPECT_EQ(blender5.frame.features,
            (std::vector<std::string>{"radiance", "normal", "depth", "albedo", "specular", "flow"}));
  EXPECT_NE(blender5.frame.info.generator.find("Blender 5"), std::string::npos)
      << blender5.frame.info.generator;
  for (const Expected& expected : {kPlane, kSphere, kMetal}) {
    expect_surface(half_floats, 0, expected, 3e-3F);
    expect_surface(blender5.frame, 1, expected, 3e-3F);
  }
}

TEST(MitsubaPreset, FindsTheSceneThatWasRendered) {
  const ImportedFrame imported = import_with("mitsuba", samples("mitsuba", 4));
  const Frame& frame = imported.frame;
  EXPECT_EQ(frame.features, (std::vector<std::string>{"radiance", "normal", "depth", "albedo"}));
  EXPECT_EQ(frame.info.generator, "Mitsuba version 3.9.1");
  EXPECT_GT(imported.counts.above_maximum, 0);  // the metal's albedo
  for (int s = 0; s < 4; ++s) {
    expect_near(values(frame, s, "normal", kPlane.x, kPlane.y), kPlane.normal, 1e-5F);
    // Rays go through random points of a pixel.
    expect_near(values(frame, s, "depth", kPlane.x, kPlane.y), {kPlane.depth}, 0.12F);
    // Half a pixel is 0.078 there, on a sphere of radius 0.45.
    expect_near(values(frame, s, "normal", kSphere.x, kSphere.y), kSphere.normal, 0.2F);
    expect_near(values(frame, s, "depth", kSphere.x, kSphere.y), {kSphere.depth}, 0.1F);
    expect_near(values(frame, s, "albedo", kSphere.x, kSphere.y), kSphere.albedo, 1e-5F);
    EXPECT_EQ(values(frame, s, "albedo", kMetal.x, kMetal.y)[0], 1);
    EXPECT_EQ(frame.plane(s, kDepthOffset)[kSky], kEscapedDepth);
    expect_near(values(frame, s, "radiance", 14, 6), {0.8F, 1.0F, 1.5F}, 1e-5F);
  }
}

TEST(MitsubaPreset, DistancesAgreeWithPositions) {
  const Frame exact = import_with("mitsuba", samples("mitsuba", 2)).frame;
  const Frame by_distance = import_with("mitsuba", samples("mitsuba", 2), {"depth.channels=[]"}).frame;
  ASSERT_TRUE(by_distance.holds("depth"));
  for (int s = 0; s < 2; ++s)
    for (size_t p = 0; p < exact.plane_size(); ++p) {
      const float depth = exact.plane(s, kDepthOffset)[p];
      // The cosine is that of the pixel's middle: a pixel is 0.06 wide at depth 1.
      EXPECT_NEAR(by_distance.plane(s, kDepthOffset)[p], depth, 0.02F * depth) << "pixel " << p;
    }
}

TEST(Presets, ADataSetThatIsReadBack) {
  const TemporaryFolder folder;
  const DataSetPlace place{folder / "data", "shot/0001", "validation", 3, 1};
  const ImportMapping mapping = read_mapping("cycles", "", {});
  const ImportedPicture reference = import_picture(kImportFixtures / "cycles/reference.exr", mapping);
  EXPECT_EQ(reference.image.channels, 4);
  check_place(place);
  const Frame frame = import_with("cycles", samples("cycles", 4)).frame;
  add_to_data_set(place, frame, reference);
  add_to_data_set(place, frame, reference);  // replaces it
  const std::vector<ManifestFrame> entries = frames_of_split(place.folder, "validation");
  ASSERT_EQ(entries.size(), 1u);
  EXPECT_EQ(entries[0].sequence, 3);
  EXPECT_EQ(entries[0].position, 1);
  const FramePair pair = read_frame_pair(place.folder, entries[0], {"radiance", "normal", "flow"});
  EXPECT_EQ(pair.frame.features, frame.features);
  EXPECT_EQ(pair.frame.alpha, frame.alpha);
  expect_surface(pair.frame, 2, kPlane, 3e-3F);
  EXPECT_NEAR(pair.reference.image.at(2, 14, 6), 1.5F, 1e-2F);

  ImportedPicture sample = import_picture(kImportFixtures / "cycles/sample_02.exr", mapping);
  EXPECT_ERROR(add_to_data_set(place, frame, sample), "sample 2 is the reference itself");
  sample.image = Image(16, 11, 3);
  EXPECT_ERROR(add_to_data_set(place, frame, sample), "16 x 12 pixels and the reference 16 x 11");
  EXPECT_ERROR(check_place({place.folder, "../outside", "train"}), "no file name inside");
  EXPECT_ERROR(check_place({place.folder, "inside.reference", "test"}),
               "would be the reference of a frame 'inside'");
  EXPECT_ERROR(check_place({place.folder, "inside", "tests"}), "expected one of train, validation, test");
}

TEST(Presets, Complaints) {
  const std::vector<fs::path> twice = {kImportFixtures / "mitsuba/sample_00.exr",
                                       kImportFixtures / "mitsuba/sample_01.exr",
                                       kImportFixtures / "mitsuba/sample_00.exr"};
  const std::string text = error_text([&] { import_with("mitsuba", twice); });
  EXPECT_NE(text.find("sample_00.exr and "), std::string::npos) << text;
  EXPECT_NE(text.find("the same noise twice"), std::string::npos) << text;
  EXPECT_ERROR(import_with("cycles", samples("mitsuba", 1)), "no radiance: nothing fits");
  EXPECT_ERROR(import_frame(samples("cycles", 1), read_mapping("cycles", "", {}), std::nullopt, false),
               "give --camera FILE.yaml");
  EXPECT_ERROR(import_frame({}, read_mapping("cycles", "", {}), std::nullopt, false),
               "no files with samples");
  EXPECT_ERROR(read_mapping("cycle", "", {}), "did you mean 'cycles'?");
  EXPECT_ERROR(read_mapping("cycles", "", {"normal.spaces=world"}), "space");
  EXPECT_ERROR(read_mapping("cycles", "", {"normal.channels=[a, b]"}), "names 2 channels; expected 3");
  EXPECT_ERROR(read_mapping("cycles", "", {"flow.scale=[1, 2, 3]"}), "3 numbers; expected one for all");
  EXPECT_ERROR(read_mapping("cycles", "", {"radiance.channels=[]", "radiance_2.channels=[]"}),
               "no radiance.channels");
}

}  // namespace
}  // namespace ld
