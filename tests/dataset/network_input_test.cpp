#include "dataset/network_input.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/tone_map.h"
#include "dataset/training_set.h"
#include "frame/encoding.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

TEST(NetworkInput, HoldsEncodedFeaturesInTheirOrderAndLinearRadiance) {
  Frame frame = random_frame(3, 2, 2, 1);
  frame.info.depth_scale = 2;
  frame.plane(0, kDepthOffset)[4] = kEscapedDepth;
  const NetworkInput input = make_network_input({frame}, {"depth", "motion", "radiance"});
  ASSERT_EQ(input.features.sizes(), (std::vector<int64_t>{1, 2, 6, 2, 3}));
  for (int p = 0; p < 6; ++p) {
    const int y = p / 3, x = p % 3;
    const float depth = frame.plane(1, kDepthOffset)[p], motion = frame.plane(1, 15)[p],
                red = frame.plane(1, 0)[p];
    EXPECT_FLOAT_EQ(input.features[0][1][0][y][x].item<float>(), depth / (depth + 2));
    EXPECT_FLOAT_EQ(input.features[0][1][2][y][x].item<float>(), motion / (std::fabs(motion) + 16));
    EXPECT_FLOAT_EQ(input.features[0][1][3][y][x].item<float>(), tone_map(red));
    EXPECT_EQ(input.radiance[0][1][0][y][x].item<float>(), red);
  }
  EXPECT_EQ(input.features[0][0][0][1][1].item<float>(), 1);
  EXPECT_EQ(input.valid.sum().item<float>(), 12);
}

TEST(NetworkInput, SamplesThatAreNotValidAreZeroAndFillUneven) {
  Frame two = random_frame(3, 2, 2, 1);
  two.valid_plane(1)[5] = 0;
  for (int c = 0; c < kSampleChannels; ++c) two.plane(1, c)[5] = 0;
  const Frame one = random_frame(3, 2, 1, 2);
  const NetworkInput input = make_network_input({two, one}, mh20_feature_names());
  EXPECT_EQ(input.valid[0].sum().item<float>(), 11);
  EXPECT_EQ(input.valid[1].sum().item<float>(), 6);
  EXPECT_EQ(input.features[0][1].select(1, 1).select(1, 2).abs().sum().item<float>(), 0);
  EXPECT_EQ(input.features[1][1].abs().sum().item<float>(), 0);
  EXPECT_EQ(input.radiance[1][1].abs().sum().item<float>(), 0);
}

TEST(NetworkInput, SizesThatDoNotFitAndEmptyFramesAreErrors) {
  EXPECT_THROW(make_network_input({random_frame(3, 2, 1, 1), random_frame(2, 3, 1, 1)}, {"radiance"}), Error);
  EXPECT_THROW(make_network_input({}, {"radiance"}), Error);
  EXPECT_THROW(make_network_input({Frame(3, 2, 0)}, {"radiance"}), Error);
  EXPECT_THROW(make_network_input({random_frame(3, 2, 1, 1)}, {"radiances"}), UsageError);
}

TEST(Encoding, IsFiniteAndBoundedForEveryFiniteValue) {
  const float extremes[] = {0, 1e-45F, 1e-38F, 1, 65504, 3e38F, -1, -100, -3e38F};
  for (const Feature& feature : feature_schema())
    for (const float value : extremes) {
      float encoded = 0;
      encode(feature, 1e-6F, &value, &encoded, 1);
      EXPECT_TRUE(std::isfinite(encoded)) << feature.name << " of " << value;
      EXPECT_LE(std::fabs(encoded), kEscapedDepth) << feature.name << " of " << value;
    }
}

TEST(ToneMap, IsAccurateInTheDarkAndFiniteEverywhere) {
  for (double x : {1e-30, 1e-7, 1e-5, 0.001, 0.1, 1.0, 100.0, 65504.0, 3e38}) {
    EXPECT_NEAR(tone_map(static_cast<float>(x)) / tone_map(static_cast<double>(static_cast<float>(x))), 1,
                1e-6)
        << x;
    const double h = x * 1e-4;
    EXPECT_NEAR((tone_map(x + h) - tone_map(x - h)) / (2 * h) / tone_map_slope(x), 1, 1e-6) << x;
  }
  EXPECT_EQ(tone_map(-2.0F), 0);
  EXPECT_EQ(tone_map(0.0F), 0);
  for (const float x : {-1e38F, -2.0F, -0.1F, 0.0F, 1e-45F, 3e38F})
    EXPECT_TRUE(std::isfinite(tone_map_slope(x))) << x;
}

TEST(TrainingSet, BatchesDependOnSeedAndStepAlone) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 5);
  const std::vector<std::string> features = {"radiance", "normal"};
  const auto make = [&](uint64_t seed, uint64_t budget) {
    return TrainingSet(FrameStore(folder.path(), "train", features, budget), features,
                       {8, 2, true, true, seed});
  };
  TrainingSet cached = make(1, uint64_t{1} << 30), uncached = make(1, 0), other = make(2, 0);
  EXPECT_EQ(cached.steps_per_epoch(), 2);
  for (const int64_t step : {0, 1, 2, 7, 3}) {
    const Batch batch = cached.batch(step);
    EXPECT_TRUE(batch.input.features.equal(uncached.batch(step).input.features));
    EXPECT_FALSE(batch.input.features.equal(other.batch(step).input.features));
    // The tiny data set's reference is the mean of the samples: pixels and reference were cut alike.
    EXPECT_TRUE(torch::allclose(batch.input.radiance.mean(1), batch.reference, 1e-2, 1e-3));
  }
}

TEST(TrainingSet, TooFewFramesAndTooLargeCropsAreErrors) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 3);
  const auto make = [&](int64_t crop, int64_t batch) {
    return TrainingSet(FrameStore(folder.path(), "train", {"radiance"}, 0), {"radiance"},
                       {crop, batch, true, true, 1});
  };
  EXPECT_THROW(make(8, 4), UsageError);
  EXPECT_THROW(make(17, 1), UsageError);
  EXPECT_THROW(FrameStore(folder.path(), "holdout", {"radiance"}, 0), Error);
}

}  // namespace
}  // namespace ld
