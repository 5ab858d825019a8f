#include "dataset/crop.h"

#include <gtest/gtest.h>

#include <Imath/half.h>

#include <cmath>

#include "core/error.h"
#include "core/tone_map.h"
#include "frame/encoding.h"
#include "frame/half_rows.h"
#include "tests/support/expect_error.h"
#include "tests/support/filter_guides.h"
#include "tests/support/packed_crop.h"
#include "tests/support/random_frame.h"

namespace ld {
namespace {

TEST(HalfRows, EveryHalfFloatAndBack) {
  std::vector<uint16_t> bits;
  for (uint32_t i = 0; i < 1 << 16; ++i)
    if ((i & 0x7c00) != 0x7c00) bits.push_back(static_cast<uint16_t>(i));  // neither infinity nor NaN
  std::vector<float> values(bits.size());
  half_to_float(bits.data(), values.data(), bits.size());
  for (size_t i = 0; i < bits.size(); ++i) {
    Imath::half expected;
    expected.setBits(bits[i]);
    ASSERT_EQ(values[i], static_cast<float>(expected)) << bits[i];
  }
  std::vector<uint16_t> again(bits.size());
  float_to_half(values.data(), again.data(), values.size());
  EXPECT_EQ(again, bits);
}

TEST(HalfRows, RoundsToTheNearestAndBoundsForEveryLength) {
  RandomStream random(1, RandomPurpose::test);
  for (size_t count = 0; count < 40; ++count) {
    std::vector<float> values(count + 1, -7.0F);
    for (size_t i = 0; i < count; ++i) values[i] = random.uniform(-3, 3) * std::exp2(random.uniform(-24, 20));
    std::vector<uint16_t> bits(count + 1, 7);
    float_to_half(values.data(), bits.data(), count);
    for (size_t i = 0; i < count; ++i)
      EXPECT_EQ(bits[i], Imath::half(std::clamp(values[i], -65504.0F, 65504.0F)).bits()) << values[i];
    EXPECT_EQ(bits[count], 7);
    std::vector<float> back(count + 1, -7.0F);
    half_to_float(bits.data(), back.data(), count);
    EXPECT_EQ(back[count], -7.0F);
  }
}

/// The slow way: pixel by pixel, from the frame itself.
struct Expected {
  const Frame& frame;
  Augmentation a;

  /// The pixel of the frame that (x, y) of the result shows.
  size_t source(int x, int y) const {
    int width = a.result_width(), height = a.result_height();
    for (int turn = 0; turn < a.quarter_turns; ++turn) {
      // Undo a counterclockwise turn, which moved (x, y) of a picture `height` wide to (y, height - 1 - x).
      const int before = height - 1 - y;
      y = x;
      x = before;
      std::swap(width, height);
    }
    if (a.flip_y) y = height - 1 - y;
    if (a.flip_x) x = width - 1 - x;
    return static_cast<size_t>(a.y + y) * static_cast<size_t>(frame.width) + static_cast<size_t>(a.x + x);
  }

  int colour(int c) const { return a.colours[static_cast<size_t>(c)]; }

  float encoded(int s, const Feature& feature, int c, size_t p) const {
    const auto channel = size_t(c);  // of the result
    if (feature.channels == 3 && feature.name != "normal") c = colour(c);
    float v[3] = {frame.plane(s, feature.offset)[p], 0, 0};
    for (int i = 1; i < feature.channels; ++i) v[i] = frame.plane(s, feature.offset + i)[p];
    if (feature.vector != Vector::none) {
      const float up = feature.vector == Vector::y_down ? -1.0F : 1.0F;
      v[1] *= up;
      if (a.flip_x) v[0] = -v[0];
      if (a.flip_y) v[1] = -v[1];
      for (int turn = 0; turn < a.quarter_turns; ++turn) {
        const float x = v[0];
        v[0] = -v[1];
        v[1] = x;
      }
      v[1] *= up;
    }
    if (feature.encoding == Encoding::tone_map) v[c] *= a.exposure[channel];
    float result = 0;
    encode(feature, frame.info.depth_scale, &v[c], &result, 1);
    return result;
  }
};

void check_crop(const Frame& frame, const PackedFrame& packed, const Augmentation& a) {
  const CropOfFrame crop = crop_of(packed, a);
  const Expected expected = {frame, a};
  const Image mean = mean_radiance(frame);
  for (int y = 0; y < a.result_height(); ++y)
    for (int x = 0; x < a.result_width(); ++x) {
      const size_t p = expected.source(x, y);
      const auto at = static_cast<size_t>(y) * static_cast<size_t>(a.result_width()) + static_cast<size_t>(x);
      for (int c = 0; c < 3; ++c)
        ASSERT_EQ(crop.reference.plane(c)[at], a.exposure[size_t(c)] * mean.plane(expected.colour(c))[p])
            << x << " " << y;
      for (int s = 0; s < frame.spp; ++s) {
        const bool valid = frame.valid_plane(s)[p] != 0;
        ASSERT_EQ(crop.frame.valid_plane(s)[at], valid ? 1 : 0);
        for (int c = 0; c < 3; ++c)
          ASSERT_EQ(crop.radiance[static_cast<size_t>(s * 3 + c) * crop.frame.plane_size() + at],
                    valid ? a.exposure[size_t(c)] * frame.plane(s, expected.colour(c))[p] : 0.0F);
        for (const std::string& name : packed.features) {
          const Feature& feature = find_feature(name);
          for (int c = 0; c < feature.channels; ++c)
            ASSERT_EQ(crop.frame.plane(s, feature.offset + c)[at],
                      valid ? expected.encoded(s, feature, c, p) : 0.0F)
                << name << " " << c << " at " << x << " " << y;
        }
      }
    }
}

/// Masked samples, an escaped ray, sizes that no tile divides.
Frame awkward_frame(int width, int height, int spp) {
  Frame frame = random_frame(width, height, spp, 5);
  for (size_t i = 0; i < frame.valid.size(); i += 7) frame.valid[i] = 0;
  frame.plane(spp - 1, kDepthOffset)[frame.plane_size() - 1] = kEscapedDepth;
  return frame;
}

TEST(Crop, EveryPixelIsWhereAndWhatItShouldBe) {
  for (const auto& [width, height, spp] : {std::tuple(37, 21, 2), std::tuple(16, 16, 1), std::tuple(1, 1, 1),
                                           std::tuple(33, 50, 3), std::tuple(5, 17, 1)}) {
    const Frame frame = awkward_frame(width, height, spp);
    const PackedFrame packed = pack(frame);
    EXPECT_TRUE(packed.intact({0, 0, packed.tiles_x(), packed.tiles_y()}));
    for (const bool flip_x : {false, true})
      for (const bool flip_y : {false, true})
        for (int turns = 0; turns < 4; ++turns) {
          SCOPED_TRACE(testing::Message() << width << "x" << height << " " << flip_x << flip_y << turns);
          check_crop(frame, packed, whole_frame(width, height, flip_x, flip_y, turns));
        }
    Augmentation inside = whole_frame((width + 1) / 2, (height + 2) / 3, true, false, 1);
    inside.x = width / 3;
    inside.y = height / 2;
    inside.exposure = {0.7F, 0, 1};
    inside.colours = {2, 0, 1};
    check_crop(frame, packed, inside);
    inside.x = inside.y = 0;
    inside.width = inside.height = 1;
    check_crop(frame, packed, inside);
  }
}

TEST(Crop, PartsOfRadianceTurnAndShineAsItDoes) {
  const Frame frame = frame_with_filter_guides(21, 13, 2, 5);
  const std::vector<std::string> features = {"radiance", "flow", "direct", "indirect", "emission"};
  const PackedFrame packed = pack(frame, mean_radiance(frame), features);
  EXPECT_EQ(packed.features, features);
  for (const bool flip_x : {false, true})
    for (const bool flip_y : {false, true})
      for (int turns = 0; turns < 4; ++turns) {
        Augmentation a = whole_frame(21, 13, flip_x, flip_y, turns);
        check_crop(frame, packed, a);
        a.colours = {2, 0, 1};
        a.exposure = {1.75F, 1.75F, 0.5F};
        check_crop(frame, packed, a);
      }
}

TEST(Crop, WhatFiltersReadIsNotPackedUnlessItIsAskedFor) {
  const Frame with = frame_with_filter_guides(21, 13, 2, 5);
  Frame without(21, 13, 2);
  without.info.depth_scale = with.info.depth_scale;
  for (int s = 0; s < 2; ++s)
    std::copy_n(with.plane(s, 0), size_t{kSampleChannels} * with.plane_size(), without.plane(s, 0));
  const PackedFrame a = pack(with, mean_radiance(with), mh20_feature_names()),
                    b = pack(without, mean_radiance(without), mh20_feature_names());
  ASSERT_EQ(a.bytes(), b.bytes());
  EXPECT_TRUE(std::equal(a.samples, a.samples + a.tiles() * a.tile_samples(), b.samples));
}

TEST(Crop, FeaturesComeInTheOrderThatIsAskedFor) {
  Frame frame = random_frame(20, 18, 2);
  frame.features = {"flow", "radiance", "depth"};
  for (int s = 0; s < 2; ++s)
    for (int c = 0; c < 2; ++c)
      std::fill_n(frame.plane(s, kFlowOffset + c), 20 * 18, 4.0F * static_cast<float>(c + 1));
  const PackedFrame packed = pack(frame);
  EXPECT_EQ(packed.features, (std::vector<std::string>{"radiance", "depth", "flow"}));
  EXPECT_EQ(packed.channels(), 6);
  constexpr size_t kPixels = 20 * 18;
  std::vector<float> features(2 * 3 * kPixels), radiance(6 * kPixels), valid(2 * kPixels),
      reference(3 * kPixels);
  const CropPlanes planes = {features.data(), radiance.data(), valid.data(), reference.data()};
  read_crop(packed, whole_frame(20, 18), {"flow", "depth"}, planes);
  EXPECT_FLOAT_EQ(features[0], 4.0F / 20);
  EXPECT_FLOAT_EQ(features[kPixels], 8.0F / 24);
  EXPECT_NEAR(features[2 * kPixels],
              frame.plane(0, kDepthOffset)[0] / (frame.plane(0, kDepthOffset)[0] + frame.info.depth_scale),
              1e-6);
  EXPECT_EQ(radiance[0], frame.plane(0, 0)[0]);
  EXPECT_ERROR(read_crop(packed, whole_frame(20, 18), {"normal"}, planes),
               "does not hold the feature 'normal'");
}

TEST(Crop, OnlyTheSamplesThatAreAskedForAreRead) {
  constexpr int kSide = 33;
  constexpr size_t kPixels = size_t{kSide} * kSide;
  const PackedFrame packed = pack(random_frame(kSide, kSide, 5));
  const Augmentation whole = whole_frame(kSide, kSide, true, false, 3);
  const TileRange tiles = whole.tiles();
  const auto channels = static_cast<size_t>(packed.channels());
  const auto read = [&](const SampleList& samples, size_t count) {
    std::vector<float> all((channels + 4) * count * kPixels + 3 * kPixels, -1.0F);
    float* features = all.data();
    float* radiance = features + channels * count * kPixels;
    float* valid = radiance + 3 * count * kPixels;
    read_crop(packed, whole, packed.features, {features, radiance, valid, valid + count * kPixels}, samples);
    return all;
  };
  const std::vector<float> everything = read({}, 5);
  EXPECT_EQ(read({0, 1, 2, 3, 4}, 5), everything);
  const std::vector<float> expected = read({1, 3}, 2);
  for (size_t i = 0; i < 2; ++i)
    EXPECT_TRUE(std::equal(expected.begin() + static_cast<long>(i * channels * kPixels),
                           expected.begin() + static_cast<long>((i + 1) * channels * kPixels),
                           everything.begin() + static_cast<long>((2 * i + 1) * channels * kPixels)));

  // Whatever stands in the others is neither read nor checked.
  const size_t sample = channels * kTilePixels;
  for (size_t tile = 0; tile < packed.tiles(); ++tile)
    for (const size_t s : {0, 2, 4}) {
      std::fill_n(const_cast<uint16_t*>(packed.samples) + (tile * 5 + s) * sample, sample,
                  static_cast<uint16_t>(0x7e00));  // NaN
      std::fill_n(const_cast<uint8_t*>(packed.valid) + (tile * 5 + s) * kTilePixels, kTilePixels,
                  static_cast<uint8_t>(77));
    }
  EXPECT_EQ(read({1, 3}, 2), expected);
  EXPECT_TRUE(packed.intact(tiles, {1, 3}));
  for (const int s : {0, 2, 4}) EXPECT_FALSE(packed.intact(tiles, {1, s}));
  EXPECT_FALSE(packed.intact(tiles));
  EXPECT_ERROR(read({5}, 1), "5 samples has no sample 5");
}

TEST(Crop, OneOutsideIsAnError) {
  const PackedFrame packed = pack(random_frame(4, 4, 1));
  for (const auto& [x, width] : {std::pair(1, 4), std::pair(-1, 2), std::pair(0, 0), std::pair(0, 5)}) {
    Augmentation a = whole_frame(width, 2);
    a.x = x;
    EXPECT_THROW(crop_of(packed, a), Error);
  }
}

TEST(PackedFrame, NoticesAChangedByteInTheTilesThatAreAskedFor) {
  const PackedFrame packed = pack(random_frame(40, 40, 2));
  const TileRange first = {0, 0, 1, 1}, last = {2, 2, 3, 3}, all = {0, 0, 3, 3};
  auto* bytes = reinterpret_cast<uint8_t*>(const_cast<uint16_t*>(packed.samples));
  bytes[2 * 8 * packed.tile_samples()] ^= 1;
  EXPECT_TRUE(packed.intact(first));
  EXPECT_FALSE(packed.intact(last));
  bytes[2 * 8 * packed.tile_samples()] ^= 1;
  EXPECT_TRUE(packed.intact(all));
  const_cast<uint8_t*>(packed.valid)[3] ^= 1;
  EXPECT_FALSE(packed.intact(first));
  EXPECT_TRUE(packed.intact(last));
}

TEST(PackedFrame, DifficultyIsTheSmapeOfTheMean) {
  Frame frame = random_frame(17, 3, 2);
  frame.valid.assign(frame.valid.size(), 1);
  frame.valid_plane(0)[16] = frame.valid_plane(1)[16] = 0;  // one pixel of the second tile has no sample
  for (int s = 0; s < 2; ++s) std::fill_n(frame.plane(s, 0), 3 * 51, s == 0 ? 1.0F : 3.0F);
  Image reference(17, 3, 3);
  std::fill(reference.pixels.begin(), reference.pixels.end(), 1.0F);
  const PackedFrame packed = pack(frame, reference, {"radiance"});
  EXPECT_NEAR(packed.difficulty[0], 1 / 3.01, 1e-6);
  EXPECT_NEAR(packed.difficulty[1], 1 / 3.01, 1e-6);
  // 15 columns of the first tile and 1 of the second.
  const_cast<float*>(packed.difficulty)[1] = 0;
  EXPECT_NEAR(crop_difficulty(packed, 1, 0, 16, 3), 15.0 / 16 / 3.01, 1e-6);
}

}  // namespace
}  // namespace ld
