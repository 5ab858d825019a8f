#include "dataset/augmentation.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

Augmentation whole(const Frame& frame, bool flip_x = false, bool flip_y = false, int quarter_turns = 0) {
  return {0, 0, frame.width, frame.height, flip_x, flip_y, quarter_turns};
}

/// A frame whose values are half floats, so that going through the cache changes none.
Frame half_frame(int width, int height) {
  Frame frame = random_frame(width, height, 2, 3);
  for (float& value : frame.samples) value = static_cast<float>(Imath::half(value - 0.5F));
  frame.valid[1] = 0;
  return frame;
}

Frame apply(const Frame& frame, const Augmentation& augmentation) {
  return augment(to_half(frame), augmentation);
}

TEST(Augmentation, NothingChangesNothing) {
  const Frame frame = half_frame(7, 5);
  const Frame same = apply(frame, whole(frame));
  EXPECT_EQ(same.samples, frame.samples);
  EXPECT_EQ(same.valid, frame.valid);
}

TEST(Augmentation, FourTurnsAreTheIdentity) {
  const Frame frame = half_frame(7, 5);
  Frame turned = frame;
  for (int turn = 0; turn < 4; ++turn) {
    turned = apply(turned, whole(turned, false, false, 1));
    EXPECT_EQ(turned.width, turn % 2 == 0 ? 5 : 7);
    if (turn < 3) {
      EXPECT_NE(turned.samples, frame.samples);
    }
  }
  EXPECT_EQ(turned.samples, frame.samples);
  EXPECT_EQ(turned.valid, frame.valid);
}

TEST(Augmentation, TurnsAndFlipsComposeAsTheGroupOfTheSquare) {
  const Frame frame = half_frame(6, 4);
  for (int turns = 0; turns < 4; ++turns) {
    Frame one_by_one = frame;
    for (int i = 0; i < turns; ++i) one_by_one = apply(one_by_one, whole(one_by_one, false, false, 1));
    EXPECT_EQ(apply(frame, whole(frame, false, false, turns)).samples, one_by_one.samples) << turns;
  }
  EXPECT_EQ(apply(frame, whole(frame, true, true, 0)).samples,
            apply(frame, whole(frame, false, false, 2)).samples);
  const Frame flipped = apply(frame, whole(frame, true));
  EXPECT_EQ(apply(flipped, whole(flipped, true)).samples, frame.samples);
}

TEST(Augmentation, PixelsGoWhereTheyShould) {
  Image image(3, 2, 1);  // 0 1 2 / 3 4 5
  for (size_t i = 0; i < 6; ++i) image.pixels[i] = static_cast<float>(i);
  EXPECT_EQ(augment(image, {0, 0, 3, 2, true, false, 0}).pixels, (std::vector<float>{2, 1, 0, 5, 4, 3}));
  EXPECT_EQ(augment(image, {0, 0, 3, 2, false, true, 0}).pixels, (std::vector<float>{3, 4, 5, 0, 1, 2}));
  // Counterclockwise: the right column becomes the top row.
  EXPECT_EQ(augment(image, {0, 0, 3, 2, false, false, 1}).pixels, (std::vector<float>{2, 5, 1, 4, 0, 3}));
  EXPECT_EQ(augment(image, {0, 0, 3, 2, true, false, 1}).pixels, (std::vector<float>{0, 3, 1, 4, 2, 5}));
  EXPECT_EQ(augment(image, {1, 1, 2, 1, false, false, 0}).pixels, (std::vector<float>{4, 5}));
}

TEST(Augmentation, VectorsTurnWithThePixelsInTheirOwnAxes) {
  Frame frame(1, 1, 1);
  const auto channel = [&](Frame& f, const char* name, int c) -> float& {
    return f.plane(0, find_feature(name).offset + c)[0];
  };
  channel(frame, "normal", 0) = 0.25F;  // to the right
  channel(frame, "normal", 1) = 0.5F;   // up
  channel(frame, "normal", 2) = 0.75F;  // to the camera
  channel(frame, "motion", 0) = 3;      // to the right
  channel(frame, "motion", 1) = 5;      // down
  channel(frame, "lens", 0) = -0.25F;
  channel(frame, "lens", 1) = 0.125F;
  const auto vectors = [&](const Augmentation& a) {
    Frame turned = apply(frame, a);
    return std::vector<float>{channel(turned, "normal", 0), channel(turned, "normal", 1),
                              channel(turned, "normal", 2), channel(turned, "motion", 0),
                              channel(turned, "motion", 1), channel(turned, "lens", 0),
                              channel(turned, "lens", 1)};
  };
  EXPECT_EQ(vectors(whole(frame, true)), (std::vector<float>{-0.25F, 0.5F, 0.75F, -3, 5, 0.25F, 0.125F}));
  EXPECT_EQ(vectors(whole(frame, false, true)),
            (std::vector<float>{0.25F, -0.5F, 0.75F, 3, -5, -0.25F, -0.125F}));
  // A quarter turn counterclockwise takes right to up, up to left; down (of the motion) to right.
  EXPECT_EQ(vectors(whole(frame, false, false, 1)),
            (std::vector<float>{-0.5F, 0.25F, 0.75F, 5, -3, -0.125F, -0.25F}));
}

TEST(Augmentation, RandomOnesCoverTheFrameAndStayInside) {
  int flips = 0, left = 0, right = 0, turns[4] = {};
  for (uint32_t i = 0; i < 2000; ++i) {
    RandomStream stream(1, RandomPurpose::augmentation, i);
    const Augmentation a = random_augmentation(stream, 20, 10, 8, true, true);
    ASSERT_TRUE(a.x >= 0 && a.x + a.width <= 20 && a.y >= 0 && a.y + a.height <= 10);
    ASSERT_TRUE(a.width == 8 && a.height == 8);
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
  const Augmentation plain = random_augmentation(stream, 8, 8, 8, false, false);
  EXPECT_FALSE(plain.flip_x || plain.flip_y);
  EXPECT_EQ(plain.quarter_turns, 0);
}

TEST(Augmentation, ACropOutsideIsAnError) {
  const Frame frame = half_frame(4, 4);
  EXPECT_THROW(apply(frame, {1, 0, 4, 4, false, false, 0}), Error);
  EXPECT_THROW(apply(frame, {-1, 0, 2, 2, false, false, 0}), Error);
  EXPECT_THROW(apply(frame, {0, 0, 0, 2, false, false, 0}), Error);
}

}  // namespace
}  // namespace ld
