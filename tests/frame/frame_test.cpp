// Frames in memory: their zeros, and the median of their depths.
#include "frame/frame.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace ld {
namespace {

/// The same by sorting.
float sorted_median(const Frame& frame) {
  std::vector<float> depths;
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p)
      if (frame.valid_plane(s)[p] != 0 && frame.plane(s, kDepthOffset)[p] < kEscapedDepth)
        depths.push_back(frame.plane(s, kDepthOffset)[p]);
  std::sort(depths.begin(), depths.end());
  return depths.empty() ? 1 : std::max(depths[depths.size() / 2], 1e-6F);
}

TEST(MedianDepth, IsThatOfTheSortedDepthsOnAnyNumberOfThreads) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> exponent(-30, 16), share(0, 1);
  for (const auto& [width, height, spp] : {std::array{1, 1, 1}, {3, 5, 2}, {301, 517, 2}}) {
    for (const float negative : {0.0F, 0.4F, 0.9F}) {
      Frame frame(width, height, spp);
      for (int s = 0; s < spp; ++s)
        for (size_t p = 0; p < frame.plane_size(); ++p) {
          float& depth = frame.plane(s, kDepthOffset)[p];
          depth = std::exp2(exponent(random)) * (share(random) < negative ? -1.0F : 1.0F);
          if (share(random) < 0.1F) depth = kEscapedDepth;
          if (share(random) < 0.1F) depth = share(random) < 0.5F ? 0.0F : -0.0F;
          frame.valid_plane(s)[p] = share(random) < 0.9F ? 1 : 0;
        }
      for (const int threads : {1, 2, 7}) EXPECT_EQ(median_depth(frame, threads), sorted_median(frame));
    }
  }
}

TEST(MedianDepth, OfNothingIsOne) {
  Frame frame(4, 4, 1);
  std::fill_n(frame.plane(0, kDepthOffset), 16, kEscapedDepth);
  EXPECT_EQ(median_depth(frame), 1);
  std::fill_n(frame.plane(0, kDepthOffset), 16, std::numeric_limits<float>::quiet_NaN());
  EXPECT_EQ(median_depth(frame), 1);
  std::fill_n(frame.plane(0, kDepthOffset), 16, 3.0F);
  EXPECT_EQ(median_depth(frame), 3);
  frame.features = {"radiance"};
  EXPECT_EQ(median_depth(frame), 1);
}

TEST(FrameMemory, IsZerosThatCopiesKeepAndCountsWhatIsHeld) {
  for (const int side : {1, 7, 600}) {
    Frame frame(side, side, 2);
    EXPECT_TRUE(std::all_of(frame.samples.begin(), frame.samples.end(), [](float v) { return v == 0; }));
    frame.plane(1, kDepthOffset)[0] = 5;
    const Frame copy = frame;
    EXPECT_EQ(copy.samples, frame.samples);
    const auto samples = int64_t(frame.valid.size());
    EXPECT_EQ(frame.bytes(), samples * (20 * 4 + 1));
    frame.features = {"radiance", "depth"};
    frame.alpha.resize(frame.valid.size());
    EXPECT_EQ(frame.bytes(), samples * (4 * 4 + 1 + 4));
  }
}

}  // namespace
}  // namespace ld
