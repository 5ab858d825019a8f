#include "dataset/augmentation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "tests/support/packed_crop.h"
#include "tests/support/random_frame.h"

namespace ld {
namespace {

TEST(Augmentation, FourTurnsAreTheIdentity) {
  // Turn by turn, each time from a frame packed anew: normals and lens positions are not encoded.
  Frame frame = random_frame(7, 5, 2);
  frame.features = {"radiance", "normal", "lens"};
  Frame turned = frame;
  for (int turn = 0; turn < 4; ++turn) {
    const CropOfFrame crop = crop_of(pack(turned), whole_frame(turned.width, turned.height, false, false, 1));
    EXPECT_EQ(crop.frame.width, turn % 2 == 0 ? 5 : 7);
    turned = crop.frame;
    turned.info = frame.info;
    for (int s = 0; s < 2; ++s) std::copy_n(crop.radiance.begin() + s * 105, 105, turned.plane(s, 0));
    EXPECT_EQ(turned.samples == crop_of(pack(frame), whole_frame(7, 5)).frame.samples, false);
  }
  for (int s = 0; s < 2; ++s)
    for (const char* name : {"radiance", "normal", "lens"})
      for (int c = 0; c < find_feature(name).channels; ++c)
        for (size_t p = 0; p < 35; ++p) {
          const int plane = find_feature(name).offset + c;
          ASSERT_EQ(turned.plane(s, plane)[p], frame.plane(s, plane)[p]) << name << c << " " << p;
        }
}

TEST(Augmentation, PixelsGoWhereTheyShould) {
  Frame frame(3, 2, 1);  // 0 1 2 / 3 4 5
  for (size_t i = 0; i < 6; ++i) frame.plane(0, 0)[i] = static_cast<float>(i);
  frame.info.depth_scale = 1;
  const auto reds = [&](bool flip_x, bool flip_y, int turns) {
    const Image image = crop_of(pack(frame), whole_frame(3, 2, flip_x, flip_y, turns)).reference;
    return std::vector<float>(image.pixels.begin(), image.pixels.begin() + 6);
  };
  EXPECT_EQ(reds(true, false, 0), (std::vector<float>{2, 1, 0, 5, 4, 3}));
  EXPECT_EQ(reds(false, true, 0), (std::vector<float>{3, 4, 5, 0, 1, 2}));
  // Counterclockwise: the right column becomes the top row.
  EXPECT_EQ(reds(false, false, 1), (std::vector<float>{2, 5, 1, 4, 0, 3}));
  EXPECT_EQ(reds(false, false, 2), reds(true, true, 0));
}

TEST(Augmentation, VectorsTurnWithThePixelsInTheirOwnAxes) {
  Frame frame(1, 1, 1);
  frame.info.depth_scale = 1;
  const auto channel = [](Frame& f, const char* name, int c) -> float& {
    return f.plane(0, find_feature(name).offset + c)[0];
  };
  channel(frame, "normal", 0) = 0.25F;  // to the right
  channel(frame, "normal", 1) = 0.5F;   // up
  channel(frame, "normal", 2) = 0.75F;  // to the camera
  channel(frame, "motion", 0) = 16;     // to the right; squashed to 1/2
  channel(frame, "motion", 1) = 48;     // down; 3/4
  channel(frame, "lens", 0) = -0.25F;
  channel(frame, "lens", 1) = 0.125F;
  const auto vectors = [&](bool flip_x, bool flip_y, int turns) {
    Frame turned = crop_of(pack(frame), whole_frame(1, 1, flip_x, flip_y, turns)).frame;
    return std::vector<float>{channel(turned, "normal", 0), channel(turned, "normal", 1),
                              channel(turned, "normal", 2), channel(turned, "motion", 0),
                              channel(turned, "motion", 1), channel(turned, "lens", 0),
                              channel(turned, "lens", 1)};
  };
  EXPECT_EQ(vectors(true, false, 0), (std::vector<float>{-0.25F, 0.5F, 0.75F, -0.5F, 0.75F, 0.25F, 0.125F}));
  EXPECT_EQ(vectors(false, true, 0),
            (std::vector<float>{0.25F, -0.5F, 0.75F, 0.5F, -0.75F, -0.25F, -0.125F}));
  // A quarter turn counterclockwise takes right to up, up to left; down (of the motion) to right.
  EXPECT_EQ(vectors(false, false, 1),
            (std::vector<float>{-0.5F, 0.25F, 0.75F, 0.75F, -0.5F, -0.125F, -0.25F}));
}

TEST(Augmentation, RandomOnesCoverTheFrameAndStayInside) {
  const PackedFrame frame = pack(random_frame(20, 10, 1));
  int flips = 0, left = 0, right = 0, turns[4] = {};
  for (uint32_t i = 0; i < 2000; ++i) {
    RandomStream stream(1, RandomPurpose::augmentation, i);
    const Augmentation a = random_augmentation(stream, {&frame}, {8, true, true, 1, 0});
    ASSERT_TRUE(a.x >= 0 && a.x + a.width <= 20 && a.y >= 0 && a.y + a.height <= 10);
    ASSERT_TRUE(a.width == 8 && a.height == 8);
    ASSERT_EQ(a.exposure, (std::array<float, 3>{1, 1, 1}));
    flips += a.flip_x;
    left += a.x == 0;
    right += a.x == 12;
    ++turns[a.quarter_turns];
  }
  EXPECT_NEAR(flips, 1000, 150);
  EXPECT_GT(left, 50);
  EXPECT_GT(right, 50);
  for (const int count : turns) EXPECT_NEAR(count, 500, 120);
  RandomStream stream(1, RandomPurpose::augmentation);
  const Augmentation plain = random_augmentation(stream, {&frame}, {32, false, false, 1, 0});
  EXPECT_FALSE(plain.flip_x || plain.flip_y);
  EXPECT_EQ(plain.quarter_turns, 0);
  EXPECT_EQ(plain.width, 20);
  EXPECT_EQ(plain.height, 10);
}

TEST(Augmentation, ExposureIsUniformInStopsAndChangesNoCrop) {
  const PackedFrame frame = pack(random_frame(20, 10, 1));
  int brighter = 0;
  float low = 1, high = 1;
  for (uint32_t i = 0; i < 2000; ++i) {
    RandomStream stream(1, RandomPurpose::augmentation, i), same(1, RandomPurpose::augmentation, i);
    const Augmentation a = random_augmentation(stream, {&frame}, {8, true, true, 1, 2});
    const Augmentation plain = random_augmentation(same, {&frame}, {8, true, true, 1, 0});
    ASSERT_TRUE(a.x == plain.x && a.y == plain.y && a.flip_x == plain.flip_x &&
                a.quarter_turns == plain.quarter_turns);
    brighter += a.exposure[0] > 2;  // the upper quarter
    low = std::min(low, a.exposure[0]);
    high = std::max(high, a.exposure[0]);
  }
  EXPECT_NEAR(brighter, 500, 120);
  EXPECT_GE(low, 0.25F);
  EXPECT_LE(high, 4.0F);
  EXPECT_LT(low, 0.26F);
  EXPECT_GT(high, 3.9F);
}

TEST(Augmentation, ColoursComeInAllOrdersAndChangeNothingElse) {
  const PackedFrame frame = pack(random_frame(20, 10, 1));
  std::map<std::array<int, 3>, int> orders;
  for (uint32_t i = 0; i < 1200; ++i) {
    RandomStream stream(1, RandomPurpose::augmentation, i), same(1, RandomPurpose::augmentation, i);
    Augmentation a = random_augmentation(stream, {&frame}, {8, true, true, 2, 1, true});
    const Augmentation plain = random_augmentation(same, {&frame}, {8, true, true, 2, 1, false});
    ++orders[a.colours];
    ASSERT_TRUE(a.x == plain.x && a.y == plain.y && a.flip_x == plain.flip_x &&
                a.quarter_turns == plain.quarter_turns && a.exposure == plain.exposure);
    ASSERT_EQ(plain.colours, (std::array<int, 3>{0, 1, 2}));
  }
  ASSERT_EQ(orders.size(), 6);
  for (const auto& [order, count] : orders) EXPECT_NEAR(count, 200, 60);
}

TEST(Augmentation, DifficultyPrefersTheNoisyHalf) {
  // Left half: the mean is the reference; right half: it is far off.
  Frame frame = random_frame(64, 32, 1);
  Image reference = mean_radiance(frame);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < 32; ++y)
      for (int x = 32; x < 64; ++x) reference.at(c, x, y) += 1;
  const PackedFrame noisy = pack(frame, reference, frame.features), calm = pack(frame);
  const auto right_half = [&](const PackedFrame& packed, int candidates) {
    int count = 0;
    for (uint32_t i = 0; i < 1000; ++i) {
      RandomStream stream(1, RandomPurpose::augmentation, i);
      count += random_augmentation(stream, {&packed}, {16, true, true, candidates, 0}).x >= 24;
    }
    return count;
  };
  EXPECT_NEAR(right_half(noisy, 1), 510, 60);  // 25 of 49 positions
  EXPECT_GT(right_half(noisy, 4), 800);
  EXPECT_GT(right_half(noisy, 16), 900);
  EXPECT_NEAR(right_half(calm, 4), 510, 60);  // nothing to choose by
  // Of a clip, the frames together: one that is calm changes nothing.
  RandomStream one(1, RandomPurpose::augmentation), two(1, RandomPurpose::augmentation);
  const Augmentation of_clip = random_augmentation(two, {&calm, &noisy}, {16, true, true, 16, 0});
  EXPECT_EQ(of_clip.x, random_augmentation(one, {&noisy}, {16, true, true, 16, 0}).x);
  EXPECT_EQ(one.bits(), two.bits());
}

TEST(Augmentation, HalfOfTheClipsRunBackwardsWhereAskedAndNothingElseChanges) {
  const PackedFrame frame = pack(random_frame(20, 10, 1));
  int reversed = 0;
  for (uint32_t i = 0; i < 1000; ++i) {
    RandomStream stream(1, RandomPurpose::augmentation, i), same(1, RandomPurpose::augmentation, i);
    const Augmentation a = random_augmentation(stream, {&frame}, {8, true, true, 1, 1, true, true});
    const Augmentation plain = random_augmentation(same, {&frame}, {8, true, true, 1, 1, true, false});
    reversed += a.reversed;
    ASSERT_FALSE(plain.reversed);
    ASSERT_TRUE(a.x == plain.x && a.y == plain.y && a.flip_x == plain.flip_x && a.colours == plain.colours &&
                a.quarter_turns == plain.quarter_turns && a.exposure == plain.exposure);
  }
  EXPECT_NEAR(reversed, 500, 80);
}

// A sample that was never drawn stays 0.
TEST(Augmentation, BackwardsTheMotionIsTheOppositeAndTheTimeTheRest) {
  Frame frame = random_frame(2, 1, 1);
  frame.valid[1] = 0;
  sanitise(frame);
  const int motion = find_feature("motion").offset, time = find_feature("time").offset;
  frame.plane(0, motion)[0] = 16;
  frame.plane(0, motion + 1)[0] = 0;
  frame.plane(0, time)[0] = 0.25F;
  Augmentation back = whole_frame(2, 1, false, false, 0);
  const Frame before = crop_of(pack(frame), back).frame;
  back.reversed = true;
  const Frame after = crop_of(pack(frame), back).frame;
  for (int c = 0; c < channel_count(frame.features); ++c)
    for (int x = 0; x < 2; ++x) {
      const float was = before.plane(0, c)[x], is = after.plane(0, c)[x];
      const bool moves = c == motion || c == motion + 1;
      EXPECT_EQ(is, moves ? -was : (c == time && x == 0 ? 0.75F : was)) << c;
    }
  EXPECT_EQ(after.plane(0, motion)[0], -0.5F);
  EXPECT_FALSE(std::signbit(after.plane(0, motion + 1)[0]));
}

}  // namespace
}  // namespace ld
