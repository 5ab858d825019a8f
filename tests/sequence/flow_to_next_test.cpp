// Where surfaces will be, from where those of the next frame were.
#include "sequence/flow_to_next.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/sequence/wall.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {

void show(SurfaceGuides& guides, int x, int y, float depth, float flow_x) {
  const size_t p = guides.index(x, y);
  guides.surface[p].depth = depth;
  guides.depth[p] = depth;
  guides.flow_x[p] = flow_x;
}

TEST(FlowToNext, WhatStandsStillDoes) {
  const Image flow = flow_to_next(wall(5, 3, 4), wall(5, 3, 4));
  for (const float value : flow.pixels) {
    EXPECT_EQ(value, 0);
    EXPECT_FALSE(std::signbit(value));
  }
}

// The next frame shows at x what lay at x + 1.5 in this one: it moves by -1.5, and what leaves is unknown.
TEST(FlowToNext, TurnsAMovementAround) {
  const Image flow = flow_to_next(wall(6, 4, 4), wall(6, 4, 4, 1.5F, -1));
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 6; ++x) {
      const bool told = x >= 1 && y < 3;
      EXPECT_EQ(flow.at(0, x, y), told ? -1.5F : kNoFlow) << x << " " << y;
      EXPECT_EQ(flow.at(1, x, y), told ? 1 : kNoFlow) << x << " " << y;
    }
}

// A ball at depth 2 moves from pixel 2 to pixel 4 in front of a wall that stands still.
TEST(FlowToNext, WhatAPixelShowsDecides) {
  SurfaceGuides now = wall(7, 1, 8), next = wall(7, 1, 8);
  show(now, 2, 0, 2, 0);
  show(next, 4, 0, 2, -2);
  const Image flow = flow_to_next(now, next);
  for (int x = 0; x < 7; ++x)
    EXPECT_EQ(flow.at(0, x, 0), x == 2 ? 2 : x == 4 ? kNoFlow : 0) << x << ": the ball hides 4 then";
  // Nearer to the middle of pixel 2 lands a piece of the wall, which it does not show.
  SurfaceGuides beside = next;
  show(beside, 4, 0, 2, -1.75F);
  EXPECT_EQ(flow_to_next(now, beside).at(0, 2, 0), 1.75F);
  // Where nothing else arrives, another surface counts: whoever looks there compares.
  show(now, 2, 0, 8, 0);
  show(beside, 2, 0, 8, 9);
  EXPECT_EQ(flow_to_next(now, beside).at(0, 2, 0), 1.75F);
}

TEST(FlowToNext, NumbersThatAreNone) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          3e38F, -3e38F, kNoFlow}) {
    const Image flow = flow_to_next(wall(1, 1, 4), wall(1, 1, 4, bad, 0));
    EXPECT_EQ(flow.at(0, 0, 0), kNoFlow);
    EXPECT_EQ(flow.at(1, 0, 0), kNoFlow);
  }
  EXPECT_EQ(flow_to_next(wall(1, 1, 4), wall(1, 1, 4, 1e-38F, -1e-42F)).at(1, 0, 0), 1e-42F);
  EXPECT_ERROR(flow_to_next(wall(2, 1, 4), wall(1, 1, 4)), "expected one size");
}

TEST(FlowToNext, SamplesOfAPixelGetItUnlessMasked) {
  Frame frame(2, 1, 2);
  frame.valid_plane(1)[0] = 0;
  Image flow(2, 1, 2);
  flow.pixels = {1, 2, 3, 4};
  set_flow(frame, flow);
  for (int s = 0; s < 2; ++s)
    for (int c = 0; c < 2; ++c)
      for (size_t p = 0; p < 2; ++p)
        EXPECT_EQ(frame.plane(s, kFlowOffset + c)[p], s == 1 && p == 0 ? 0 : flow.plane(c)[p]);
}

}  // namespace
}  // namespace ld
