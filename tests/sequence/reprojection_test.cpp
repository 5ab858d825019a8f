// Which pixels of neighbouring frames show the same surface.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sequence/surface_guides.h"
#include "tests/sequence/wall.h"

namespace ld {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

TEST(Reprojection, ConstantsAndSigns) {
  const SeenSurface now{10, 0, 0, 1, 3};
  const float tolerance = depth_tolerance(0, 10);
  EXPECT_FLOAT_EQ(tolerance, 0.1F);
  EXPECT_TRUE(is_same_surface(now, 10, tolerance, {10.09F, 0, 0, 1, 3}));
  EXPECT_FALSE(is_same_surface(now, 10, tolerance, {10.11F, 0, 0, 1, 3}));
  EXPECT_FALSE(is_same_surface(now, 10, tolerance, {10, 0, 0, 1, 4})) << "another object";
  EXPECT_TRUE(is_same_surface(now, 10, tolerance, {10, std::sqrt(1 - 0.91F * 0.91F), 0, 0.91F, 3}));
  EXPECT_FALSE(is_same_surface(now, 10, tolerance, {10, std::sqrt(1 - 0.89F * 0.89F), 0, 0.89F, 3}));
  EXPECT_FALSE(is_same_surface(now, 10, tolerance, {10, 0, 0, -1, 3})) << "the back of it";
}

TEST(Reprojection, WhatIsNotANumberIsAnotherSurface) {
  const SeenSurface now{10, 0, 0, 1, 0};
  for (const float bad : {kNan, kInfinity, -kInfinity, 3e38F}) {
    EXPECT_FALSE(is_same_surface(now, 10, 1, {bad, 0, 0, 1, 0}));
    EXPECT_FALSE(is_same_surface(now, bad, 1, now));
    EXPECT_FALSE(is_same_surface({10, 0, 0, bad, 0}, 10, 1, {10, 0, 0, kNan, 0}));
  }
  for (const float bad : {kNan, kInfinity, -kInfinity, 3e38F, -3e38F})
    for (const BilinearTap& tap : bilinear_taps(bad, 0, 4, 3)) EXPECT_EQ(tap.weight, 0);
}

TEST(Reprojection, TapsAreBilinearAndThoseOutsideAreLeftOut) {
  const auto taps = bilinear_taps(1.25F, 0.5F, 4, 3);
  EXPECT_FLOAT_EQ(taps[0].weight, 0.375F);
  EXPECT_FLOAT_EQ(taps[1].weight, 0.125F);
  EXPECT_EQ(taps[3].x, 2);
  EXPECT_EQ(taps[3].y, 1);
  const auto corner = bilinear_taps(-0.5F, -0.5F, 1, 1);
  EXPECT_FLOAT_EQ(corner[3].weight, 0.25F);
  EXPECT_EQ(corner[0].weight + corner[1].weight + corner[2].weight, 0);
}

TEST(Reprojection, TheSlopeIgnoresAnEdgeOnOneSide) {
  const float row[] = {1, 1.5F, 2, 9, 65504};
  EXPECT_FLOAT_EQ(depth_slope(row, 5, 1, 1, 0, 65504), 0.5F);
  EXPECT_FLOAT_EQ(depth_slope(row, 5, 1, 2, 0, 65504), 0.5F);
  EXPECT_FLOAT_EQ(depth_slope(row, 5, 1, 3, 0, 65504), 7);
  EXPECT_EQ(depth_slope(row, 1, 1, 0, 0, 65504), 0);
}

TEST(Reprojection, AStillWallIsFoundInItsPlaceAndAMovedOneAtItsFlow) {
  for (const auto& [width, height] : {std::pair{1, 1}, {5, 3}, {3, 7}})
    for (const Reprojection& found : reproject(wall(width, height, 4), wall(width, height, 4))) {
      EXPECT_TRUE(found.valid);
      EXPECT_EQ(found.taps[0].weight, 1);
    }
  const auto moved = reproject(wall(5, 3, 4, -1, 0), wall(5, 3, 4));
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x) EXPECT_EQ(moved[size_t(y) * 5 + size_t(x)].valid, x > 0);
}

TEST(Reprojection, WhatCameIntoViewHasNoPast) {
  const SurfaceGuides now = wall(6, 1, 4);
  SurfaceGuides before = wall(6, 1, 4);
  for (int x = 2; x < 4; ++x) before.surface[size_t(x)].depth = 1;  // something stood before the wall
  before.surface[5].depth = kEscapedDepth;
  const auto found = reproject(now, before);
  for (int x = 0; x < 6; ++x) EXPECT_EQ(found[size_t(x)].valid, x < 2 || x == 4) << x;
}

TEST(Reprojection, AnEdgeThatFlickersIsSeenBesideIt) {
  SurfaceGuides now = wall(6, 3, 4), before = wall(6, 3, 4);
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 3; ++x) now.surface[now.index(x, y)].id = before.surface[before.index(x, y)].id = 1;
  before.surface[before.index(2, 1)].id = 0;  // the sample hit the other side
  const Reprojection found = reproject(now, before)[now.index(2, 1)];
  EXPECT_FALSE(found.valid);
  EXPECT_EQ(found.seen_at, int64_t(before.index(1, 0)));
  before.surface.assign(18, SeenSurface{4, 0, 0, 1, 9});
  EXPECT_EQ(reproject(now, before)[now.index(2, 1)].seen_at, -1);
  for (const float far : {kNan, kInfinity, -3e38F, 100.0F}) {
    now.flow_x.assign(18, far);
    EXPECT_EQ(reproject(now, wall(6, 3, 4))[now.index(4, 1)].seen_at, -1) << far;
  }
}

TEST(Reprojection, ADollyNeedsTheFlowAlongTheDepth) {
  SurfaceGuides now = wall(3, 3, 4);
  const SurfaceGuides before = wall(3, 3, 5);
  EXPECT_FALSE(reproject(now, before)[4].valid);
  now.flow_z.assign(9, 1);
  EXPECT_TRUE(reproject(now, before)[4].valid);
}

TEST(Reprojection, WeightsOfTheTapsThatPassSumToOne) {
  SurfaceGuides before = wall(4, 4, 4);
  before.surface[before.index(2, 1)].id = 7;
  const auto found = reproject(wall(4, 4, 4, 0.5F, 0), before);
  const Reprojection& half = found[before.index(1, 1)];
  EXPECT_TRUE(half.valid);
  EXPECT_EQ(half.taps[0].weight, 1);
  EXPECT_EQ(half.taps[1].weight, 0);
}

TEST(Reprojection, WithoutFlowOrWithAnotherSizeNothingIsKnown) {
  SurfaceGuides now = wall(2, 2, 4);
  EXPECT_FALSE(reproject(now, wall(3, 2, 4))[0].valid);
  now.has_flow = false;
  EXPECT_FALSE(reproject(now, wall(2, 2, 4))[0].valid);
}

TEST(SurfaceGuides, OneSampleOfTheMedianDepthStandsForThePixel) {
  Frame frame(1, 1, 4);
  frame.features.push_back("flow");
  const float depths[] = {7, 2, 5, 3};
  for (int s = 0; s < 4; ++s) {
    frame.plane(s, kDepthOffset)[0] = depths[s];
    frame.plane(s, kNormalOffset)[0] = depths[s] / 10;
    frame.plane(s, kFlowOffset)[0] = 10 * depths[s];
  }
  const SurfaceGuides guides = surface_guides(frame);
  EXPECT_EQ(guides.surface[0].depth, 3) << "the lower median of 2, 3, 5, 7";
  EXPECT_EQ(guides.surface[0].nx, 0.3F);
  EXPECT_EQ(guides.flow_x[0], 30);
  EXPECT_TRUE(guides.has_flow);
  frame.valid = {0, 1, 0, 0};
  EXPECT_EQ(surface_guides(frame).surface[0].depth, 2);
  frame.valid.assign(4, 0);
  EXPECT_EQ(surface_guides(frame).surface[0].depth, kEscapedDepth);
}

TEST(SurfaceGuides, WhatAFrameDoesNotHoldIsTheSameEverywhere) {
  Frame frame(2, 1, 1);
  frame.features = {"radiance"};
  const SurfaceGuides guides = surface_guides(frame);
  EXPECT_FALSE(guides.has_flow);
  EXPECT_EQ(guides.surface[1].depth, 1);
  EXPECT_EQ(guides.surface[1].nz, 1);
}

}  // namespace
}  // namespace ld
