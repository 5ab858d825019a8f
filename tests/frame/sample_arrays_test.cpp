// Samples in somebody else's arrays are those of a frame, whatever the strides and the values.
#include "frame/sample_arrays.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace ld {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr std::array<float, 9> kOdd = {0, -1, 1e-38F, -1e-42F, 65504, 3e38F, kNan, INFINITY, -INFINITY};

/// [spp, height, width, channels], each row `gap` floats longer than it need be.
struct Interleaved {
  std::vector<float> values;
  StridedArray strides;

  Interleaved(const SampleArrays& of, int channels, int gap, std::mt19937& random) {
    const ptrdiff_t row = ptrdiff_t{channels} * of.width + gap;
    values.resize(static_cast<size_t>(row * of.height * of.spp));
    std::uniform_real_distribution<float> value(0, 4);
    for (float& v : values) v = random() % 9 == 0 ? kOdd[random() % kOdd.size()] : value(random);
    strides = {values.data(), row * of.height, 1, row, channels};
  }
};

TEST(SampleArrays, CopiesAreTheSanitisedFrame) {
  std::mt19937 random(3);
  for (const auto& [width, height, spp] : {std::array{1, 1, 1}, {7, 3, 2}, {129, 5, 3}}) {
    SampleArrays arrays;
    arrays.width = width;
    arrays.height = height;
    arrays.spp = spp;
    Frame frame(width, height, spp);
    frame.features = {"radiance", "depth", "albedo"};
    std::vector<uint8_t> valid(frame.valid.size());
    for (uint8_t& drawn : valid) drawn = random() % 7 == 0 ? 0 : 2;
    arrays.valid = valid.data();
    std::vector<Interleaved> memory;
    for (const std::string& name : frame.features)
      memory.emplace_back(arrays, find_feature(name).channels, 5, random);
    memory.emplace_back(arrays, 3, 0, random);  // a part
    memory.emplace_back(arrays, 1, 2, random);  // alpha
    for (size_t i = 0; i < 3; ++i)
      arrays.features.push_back({&find_feature(frame.features[i]), memory[i].strides});
    arrays.parts = {memory[3].strides};
    arrays.alpha = memory[4].strides;
    frame.add_part("");
    frame.alpha.resize(valid.size());
    for (size_t i = 0; i < valid.size(); ++i) frame.valid[i] = valid[i] != 0 ? 1 : 0;
    const auto fill = [&](const StridedArray& from, int channels, const auto& plane_of) {
      for (int s = 0; s < spp; ++s)
        for (int c = 0; c < channels; ++c)
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
              plane_of(s, c)[y * width + x] =
                  from.data[s * from.sample + c * from.channel + y * from.row + x * from.pixel];
    };
    for (const SampleArrays::OfFeature& held : arrays.features)
      fill(held.array, held.feature->channels,
           [&](int s, int c) { return frame.plane(s, held.feature->offset + c); });
    fill(arrays.parts[0], 3, [&](int s, int c) { return frame.part_plane(0, s, c); });
    fill(*arrays.alpha, 1, [&](int s, int) { return frame.alpha.data() + size_t(s) * frame.plane_size(); });
    sanitise(frame);

    Frame copy = arrays.make_frame(width, height, spp);
    for (int s = 0; s < spp; ++s)
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; x += 50)
          arrays.copy({s, y, x, std::min(50, width - x)}, copy, s, size_t(y) * size_t(width) + size_t(x));
    EXPECT_EQ(copy.features, frame.features);
    EXPECT_EQ(copy.valid, frame.valid);
    EXPECT_EQ(copy.alpha, frame.alpha);
    EXPECT_EQ(copy.parts[0].samples, frame.parts[0].samples);
    EXPECT_EQ(copy.samples, frame.samples);
    for (const int threads : {1, 3})
      EXPECT_EQ(median_depth(arrays, frame.valid.data(), threads), median_depth(frame));
    EXPECT_EQ(arrays.any_valid(), std::count(frame.valid.begin(), frame.valid.end(), 1) > 0);
  }
}

TEST(SampleArrays, OfNothingThatCountsHaveNoValidSample) {
  const std::vector<float> radiance(2 * 2 * 3, kNan);
  SampleArrays arrays;
  arrays.width = arrays.height = 2;
  arrays.spp = 1;
  arrays.features = {{&find_feature("radiance"), {radiance.data(), 12, 1, 6, 3}}};
  EXPECT_FALSE(arrays.any_valid());
  EXPECT_EQ(median_depth(arrays, nullptr, 1), 1);  // there is no depth
}

}  // namespace
}  // namespace ld
