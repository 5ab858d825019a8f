#include "dataset/input_tensors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/tone_map.h"
#include "frame/encoding.h"
#include "tests/support/packed_crop.h"
#include "tests/support/random_frame.h"

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
      if (feature.encoding == Encoding::none) {
        EXPECT_THROW(require_network_feature(feature.name), UsageError);
        continue;
      }
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

TEST(NetworkInput, ACropOfThePackedFrameIsTheSameAsTheFrame) {
  Frame frame = random_frame(19, 23, 2, 1), fewer = random_frame(19, 23, 1, 2);
  frame.valid_plane(1)[5] = 0;
  for (int c = 0; c < kSampleChannels; ++c) frame.plane(1, c)[5] = 0;
  const std::vector<std::string> features = {"depth", "motion", "radiance", "coc", "time"};
  std::vector<FrameCrop> crops;
  for (const Frame& one : {frame, fewer})
    crops.push_back({std::make_shared<const PackedFrame>(pack(one)), whole_frame(19, 23)});
  const Batch batch = make_batch(crops, features);
  const NetworkInput expected = make_network_input({frame, fewer}, features);
  EXPECT_TRUE(batch.input.features.equal(expected.features));
  EXPECT_TRUE(batch.input.radiance.equal(expected.radiance));
  EXPECT_TRUE(batch.input.valid.equal(expected.valid));
  EXPECT_TRUE(batch.reference[0].equal(to_tensor(mean_radiance(frame))));
}

TEST(NetworkInput, CropsOfSeveralSizesAndEmptyBatchesAreErrors) {
  const auto frame = std::make_shared<const PackedFrame>(pack(random_frame(9, 7, 1)));
  EXPECT_THROW(
      make_batch({{frame, whole_frame(9, 7)}, {frame, whole_frame(9, 7, false, false, 1)}}, {"radiance"}),
      Error);
  EXPECT_THROW(make_batch({}, {"radiance"}), Error);
}

}  // namespace
}  // namespace ld
