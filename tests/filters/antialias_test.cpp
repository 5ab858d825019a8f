#include "filters/antialias.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "filter_scenes.h"
#include "ops/kernels/instruction_sets.h"

namespace ld {
namespace {

/// A filter and its state, as a sequence needs them.
struct AntialiasedSequence {
  double alpha = 0.1, deviations = 1;
  int threads = 1;
  AntialiasState state = {};
  RowPlanes spare = {};

  const RowPlanes& operator()(const Surfaces& surfaces, RowPlanes now) {
    antialias(surfaces, now, state, spare, alpha, deviations, threads);
    return state.picture;
  }
};

constexpr double kUnbounded = 1e6;  // deviations

Surfaces moving_wall(int width, int height, float dx, float dy) {
  Surfaces wall = flat_wall(width, height);
  for (int y = 0; y < height; ++y) {
    std::fill_n(wall.flow.row(y, 0), width, dx);
    std::fill_n(wall.flow.row(y, 1), width, dy);
  }
  return wall;
}

/// kernels/antialias_row.h for one value, from the words there.
double antialiased(const Surfaces& surfaces, const RowPlanes& now, const RowPlanes& before, int x, int y,
                   int c, double share, double deviations) {
  const int width = now.width(), height = now.height();
  float nearest = surfaces.of.at(x, y, kDepth);
  double u = x + double(surfaces.flow.at(x, y, 0)), v = y + double(surfaces.flow.at(x, y, 1));
  double sum = 0, squares = 0, count = 0;
  for (int t = std::max(y - 1, 0); t <= std::min(y + 1, height - 1); ++t)
    for (int s = std::max(x - 1, 0); s <= std::min(x + 1, width - 1); ++s) {
      const double value = now.at(s, t, c);
      sum += value;
      squares += value * value;
      ++count;
      if (surfaces.of.at(s, t, kDepth) >= nearest) continue;
      nearest = surfaces.of.at(s, t, kDepth);
      u = x + double(surfaces.flow.at(s, t, 0));
      v = y + double(surfaces.flow.at(s, t, 1));
    }
  if (u < -0.5 || v < -0.5 || u > width - 0.5 || v > height - 0.5) return now.at(x, y, c);
  u = std::clamp(u, 0.0, width - 1.0);
  v = std::clamp(v, 0.0, height - 1.0);
  const int left = int(u), top = int(v), right = std::min(left + 1, width - 1),
            down = std::min(top + 1, height - 1);
  const double fx = u - left, fy = v - top;
  double history = (1 - fy) * ((1 - fx) * before.at(left, top, c) + fx * before.at(right, top, c)) +
                   fy * ((1 - fx) * before.at(left, down, c) + fx * before.at(right, down, c));
  const double mean = sum / count,
               reach = deviations * std::sqrt(std::max(squares / count - mean * mean, 0.0));
  history = std::clamp(history, mean - reach, mean + reach);
  return share * now.at(x, y, c) + (1 - share) * history;
}

TEST(Antialias, IsItsDefinitionOnEveryInstructionSet) {
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const auto& [width, height] : {std::pair{1, 1}, {3, 40}, {45, 37}, {64, 2}})
      for (const double deviations : {1.0, 0.0, kUnbounded}) {
        AntialiasedSequence sequence{0.25, deviations};
        RowPlanes before = sequence(busy_scene(width, height, 1), noise(width, height, 3, 1));
        for (int f = 1; f < 4; ++f) {
          const Surfaces scene = busy_scene(width, height, uint64_t(f));
          const RowPlanes now = noise(width, height, 3, uint64_t(f)), out = sequence(scene, now);
          for (int c = 0; c < 3; ++c)
            for (int y = 0; y < height; ++y)
              for (int x = 0; x < width; ++x)
                ASSERT_NEAR(
                    out.at(x, y, c),
                    antialiased(scene, now, before, x, y, c, std::max(0.25, 1.0 / (f + 1)), deviations), 2e-5)
                    << set << " " << width << "x" << height << " " << deviations << " " << f << " " << x
                    << " " << y;
          before = out;
        }
      }
  }
  use_instruction_set("");
}

TEST(Antialias, AStillPictureStaysAsItIs) {
  const RowPlanes picture = noise(40, 30, 3, 7);
  AntialiasedSequence sequence{0.1, kUnbounded};
  for (int f = 0; f < 5; ++f) {
    const RowPlanes& out = sequence(flat_wall(40, 30), picture);
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < 30; ++y)
        for (int x = 0; x < 40; ++x) ASSERT_NEAR(out.at(x, y, c), picture.at(x, y, c), 1e-6);
  }
}

TEST(Antialias, NoiseFallsWithTheFramesDownToTheShare) {
  const int side = 100;
  AntialiasedSequence sequence{0.1, kUnbounded};
  for (int f = 1; f <= 60; ++f) {
    const double variance =
        spread(sequence(flat_wall(side, side), noise(side, side, 3, uint64_t(f))), 0).variance;
    if (f <= 10) {
      EXPECT_NEAR(variance, 1.0 / f, 0.06 / f) << f;
    }
    if (f == 60) {
      EXPECT_NEAR(variance, 0.1 / 1.9, 0.06 * 0.1 / 1.9);
    }
  }
}

TEST(Antialias, HistoryComesFromWhereTheSurfaceWas) {
  const int side = 30;
  AntialiasedSequence sequence{0.5, kUnbounded};
  const RowPlanes first = noise(side, side, 3, 1), now = noise(side, side, 3, 2);
  sequence(flat_wall(side, side), first);
  const RowPlanes& out = sequence(moving_wall(side, side, -3, 2), now);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const float history = x >= 3 && y < side - 2 ? first.at(x - 3, y + 2, 1) : now.at(x, y, 1);
      ASSERT_NEAR(out.at(x, y, 1), 0.5F * (now.at(x, y, 1) + history), 1e-6);
    }
}

TEST(Antialias, AnEdgeMovesWithTheNearerSurface) {
  // A card before a still wall moves 4 pixels right; its edge's history is that of the card.
  Surfaces scene = flat_wall(30, 9);
  for (int y = 0; y < 9; ++y)
    for (int x = 15; x < 25; ++x) {
      scene.of.at(x, y, kDepth) = 5;
      scene.flow.at(x, y, 0) = -4;
    }
  const RowPlanes ramp = filled(30, 9, 3, [](int, int x, int) { return float(x); });
  AntialiasedSequence sequence{0.5, kUnbounded};
  sequence(scene, ramp);
  const RowPlanes now = noise(30, 9, 3, 2), &out = sequence(scene, now);
  const auto history = [&](int x) { return 2 * out.at(x, 4, 0) - now.at(x, 4, 0); };
  EXPECT_NEAR(history(20), 16, 1e-4);
  EXPECT_NEAR(history(14), 10, 1e-4) << "of the wall, but beside the card";
  EXPECT_NEAR(history(12), 12, 1e-4);
}

TEST(Antialias, WhatChangesEverywhereIsFollowedAtOnce) {
  AntialiasedSequence sequence;
  sequence(flat_wall(20, 20), filled(20, 20, 3, [](int, int, int) { return 5.0F; }));
  const RowPlanes& out = sequence(flat_wall(20, 20), filled(20, 20, 3, [](int, int, int) { return 0.25F; }));
  for (int x = 0; x < 20; ++x) EXPECT_EQ(out.at(x, 11, 2), 0.25F);
}

TEST(Antialias, WithoutFlowAndOfAnotherSizeItStartsAnew) {
  AntialiasedSequence sequence;
  sequence(flat_wall(20, 20), noise(20, 20, 3, 1));
  Surfaces cut_away = flat_wall(20, 20);
  cut_away.has_flow = false;
  const RowPlanes now = noise(20, 20, 3, 2);
  const RowPlanes& out = sequence(cut_away, now);
  for (int y = 0; y < 20; ++y) ASSERT_TRUE(std::equal(now.row(y, 1), now.row(y, 1) + 20, out.row(y, 1)));
  EXPECT_EQ(sequence.state.frames, 1);
  const RowPlanes smaller = noise(19, 20, 3, 3);
  EXPECT_EQ(sequence(flat_wall(19, 20), smaller).at(18, 19, 0), smaller.at(18, 19, 0));
  EXPECT_EQ(sequence.state.frames, 1);
}

TEST(Antialias, ExtremesStayFiniteAndThreadsHaveTheSameBits) {
  const int width = 37, height = 29;
  for (const float extreme :
       {0.0F, 1e-38F, std::numeric_limits<float>::denorm_min(), 65504.0F, 1e37F, -1e37F}) {
    AntialiasedSequence one, three;
    three.threads = 3;
    for (int f = 0; f < 4; ++f) {
      Surfaces scene = busy_scene(width, height, uint64_t(f));
      scene.flow.at(3, 3, 0) = std::numeric_limits<float>::quiet_NaN();
      scene.flow.at(4, 4, 1) = std::numeric_limits<float>::infinity();
      scene.flow.at(5, 5, 0) = -3e38F;
      RowPlanes now = noise(width, height, 3, uint64_t(f));
      for (int x = 0; x < width; x += 2) now.at(x, 10, 1) = extreme;
      const RowPlanes a = one(scene, now), b = three(scene, now);
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < height; ++y) {
          ASSERT_TRUE(std::equal(a.row(y, c), a.row(y, c) + width, b.row(y, c))) << extreme << " " << y;
          for (int x = 0; x < width; ++x)
            ASSERT_TRUE(std::isfinite(a.at(x, y, c))) << extreme << " " << x << " " << y;
        }
    }
  }
}

}  // namespace
}  // namespace ld
