#include "dataset/varying_features.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "tests/support/filter_guides.h"
#include "tests/support/random_frame.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

using Names = std::vector<std::string>;

void fill(Frame& frame, const std::string& name, float value) {
  const Feature& feature = find_feature(name);
  for (int s = 0; s < frame.spp; ++s)
    for (int c = 0; c < feature.channels; ++c)
      std::fill_n(frame.plane(s, feature.offset + c), frame.plane_size(), value);
}

/// As a renderer without defocus and motion writes it, if it draws lens positions and times all the same.
Frame sharp_frame(uint32_t seed = 1) {
  Frame frame = random_frame(5, 3, 2, seed);
  fill(frame, "coc", 0);
  fill(frame, "motion", 0);
  return frame;
}

const Names kWithoutCamera = {"radiance", "normal", "depth", "albedo", "specular", "roughness"};

TEST(VaryingFeatures, WhatNeverVariesIsLeftOut) {
  FeatureVariation variation;
  Frame frame = random_frame(5, 3, 2);
  fill(frame, "roughness", 0.5F);
  fill(frame, "depth", 7);
  variation.add(frame);
  Names expected = mh20_feature_names();
  expected.erase(expected.begin() + 5);
  expected.erase(expected.begin() + 2);
  EXPECT_EQ(variation.used(), expected);
  EXPECT_EQ(variation.reason("roughness"), "it is 0.5 everywhere");
  EXPECT_EQ(variation.reason("flow"), "no frame holds it");
  EXPECT_EQ(variation.reason("normal"), "");
  EXPECT_FALSE(variation.settled());

  fill(frame, "roughness", 0.25F);  // constant in each frame, not in the data set
  fill(frame, "depth", 7.001F);     // rounding
  variation.add(frame);
  expected.insert(expected.begin() + 4, "roughness");
  EXPECT_EQ(variation.used(), expected);
}

TEST(VaryingFeatures, WhatFiltersReadIsNotLookedFor) {
  FeatureVariation variation;
  variation.add(frame_with_filter_guides(5, 3, 2));
  Names expected = mh20_feature_names();
  EXPECT_EQ(variation.used(), expected);
}

TEST(VaryingFeatures, LensAndTimeFollowDefocusAndMotion) {
  FeatureVariation variation;
  variation.add(sharp_frame());
  EXPECT_EQ(variation.used(), kWithoutCamera);
  EXPECT_EQ(variation.reason("lens"), "coc is 0 everywhere");
  EXPECT_FALSE(variation.settled());

  // A picture wholly out of focus: the circle of confusion is constant, the lens matters.
  Frame blurred = sharp_frame(2);
  fill(blurred, "coc", 3);
  variation.add(blurred);
  EXPECT_EQ(variation.reason("lens"), "");
  EXPECT_EQ(variation.reason("time"), "motion is 0 everywhere");

  // Without a circle of confusion nobody knows that the lens does nothing.
  FeatureVariation unknown;
  Frame without = sharp_frame();
  without.features = {"radiance", "lens", "time", "motion"};
  unknown.add(without);
  EXPECT_EQ(unknown.used(), (Names{"radiance", "lens"}));
}

TEST(VaryingFeatures, RadianceIsAlwaysUsedAndMaskedSamplesSayNothing) {
  FeatureVariation variation;
  Frame frame = random_frame(2, 2, 1);
  std::fill(frame.samples.begin(), frame.samples.end(), 0.0F);
  frame.valid = {1, 1, 0, 1};
  for (int c = 0; c < kSampleChannels; ++c) frame.plane(0, c)[2] = 1;  // masked
  variation.add(frame);
  EXPECT_EQ(variation.used(), Names{"radiance"});
  frame.valid.assign(4, 0);
  FeatureVariation nothing;
  nothing.add(frame);
  EXPECT_EQ(nothing.reason("normal"), "no frame has a valid sample");
}

class VaryingFeaturesOfFiles : public testing::Test {
 protected:
  void write(const std::string& set, int index, const std::string& split, const Frame& frame) {
    ManifestFrame entry;
    entry.name = "frame_" + std::to_string(index);
    entry.split = split;
    std::filesystem::create_directories(folder_ / set);
    write_frame(frame_path(folder_ / set, entry.name), frame);
    Manifest manifest;
    manifest.frames = {entry};
    add_to_manifest(folder_ / set, manifest);
  }
  TemporaryFolder folder_;
};

TEST_F(VaryingFeaturesOfFiles, OnlyTheSplitCountsAndEveryFrameOfIt) {
  for (int i = 0; i < 5; ++i) write("a", i, "train", sharp_frame(static_cast<uint32_t>(i)));
  write("a", 5, "test", random_frame(5, 3, 2));
  for (const int threads : {1, 4})
    EXPECT_EQ(varying_features({folder_ / "a"}, "train", threads), kWithoutCamera);

  write("a", 6, "train", random_frame(5, 3, 2));  // one blurred frame, the last
  EXPECT_EQ(varying_features({folder_ / "a"}, "train", 2), mh20_feature_names());
  EXPECT_THROW(varying_features({folder_ / "a"}, "holdout", 2), Error);
}

TEST_F(VaryingFeaturesOfFiles, AFeatureMustBeInAllFramesOfAllSets) {
  write("a", 0, "train", random_frame(5, 3, 2));
  Frame few = random_frame(7, 2, 1);
  few.features = {"radiance", "normal", "albedo"};
  write("b", 0, "train", few);
  EXPECT_EQ(varying_features({folder_ / "a", folder_ / "b"}, "train", 2), few.features);
}

}  // namespace
}  // namespace ld
