// Flips and turns of a rendered frame against a rendering of the flipped and turned scene: the renderer's
// axes and the augmentation's agree in sign for every feature.
#include <gtest/gtest.h>

#include "tests/support/flip_scene.h"
#include "tests/support/packed_crop.h"

namespace ld {
namespace {

constexpr int kSize = 24, kSpp = 3;
constexpr int64_t kSamples = int64_t{kSize} * kSize * kSpp;

/// As a network sees it; with the same depth scale for both frames.
Frame encoded(Frame frame, const Turn& turn) {
  frame.info.depth_scale = 4;
  return crop_of(pack(frame), whole_frame(kSize, kSize, turn.flip_x, turn.flip_y, turn.quarter_turns)).frame;
}

TEST(FlipScene, AugmentedFramesEqualFramesOfTheTurnedScene) {
  const Frame upright = turned_frame({}, kSize, kSpp);
  for (const bool flip_x : {false, true})
    for (const bool flip_y : {false, true})
      for (int turns = 0; turns < 4; ++turns) {
        const Turn turn{flip_x, flip_y, turns};
        // Half floats are good to 2^-11; rays that graze a silhouette may hit on one side only.
        EXPECT_LE(
            differing_samples(encoded(upright, turn), encoded(turned_frame(turn, kSize, kSpp), {}), 2e-3F),
            kSamples / 200)
            << "flip x " << flip_x << ", flip y " << flip_y << ", turns " << turns;
      }
}

TEST(FlipScene, TheComparisonNoticesAWrongSign) {
  const Frame turned = turned_frame({false, false, 1}, kSize, kSpp);
  for (const char* name : {"normal", "motion", "lens"}) {
    Frame wrong = turned;
    for (int s = 0; s < kSpp; ++s)
      for (size_t p = 0; p < wrong.plane_size(); ++p) wrong.plane(s, find_feature(name).offset)[p] *= -1;
    EXPECT_GT(differing_samples(wrong, turned, 2e-3F), kSamples / 20) << name;
  }
}

}  // namespace
}  // namespace ld
