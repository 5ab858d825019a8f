// What SVGF takes over from frame to frame.
#include <gtest/gtest.h>

#include <cmath>

#include "svgf_sequence.h"

namespace ld {
namespace {

/// A textured wall that the camera pans over: frame f shows the wall from (3f, -2f) on.
std::pair<Surfaces, RowPlanes> panned(int f, int width, int height, float dx, float dy) {
  Surfaces wall = flat_wall(width, height);
  for (int y = 0; y < height; ++y) {
    std::fill_n(wall.flow.row(y, 0), width, dx);
    std::fill_n(wall.flow.row(y, 1), width, dy);
  }
  return {wall, filled(width, height, 3, [&](int p, int x, int y) {
            const float u = float(x) + float(f) * dx + 200, v = float(y) + float(f) * dy + 200;
            return 2 + std::sin(0.31F * u + float(p)) * std::cos(0.17F * v);
          })};
}

TEST(Svgf, WholePixelPanShiftsTheHistory) {  // 2.9 e
  const int width = 40, height = 30;
  Sequence sequence{no_feedback()};
  RowPlanes before;
  for (int f = 0; f < 6; ++f) {
    auto [surfaces, signals] = panned(f, width, height, -3, 2);
    RowPlanes blank(width, height, 3);  // what comes in is black: what is there is history
    sequence(surfaces, f == 5 ? blank : signals);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        // 3 columns at the left and 2 rows below enter in each frame; those that touch what was seen before
        // find it among the 3x3 pixels.
        const float length = sequence.length(x, y);
        ASSERT_TRUE(length == 1 || (x >= 2 && y < height - 1)) << f << " " << x << " " << y;
        ASSERT_TRUE(length == float(f + 1) || x < 3 * f || y >= height - 2 * f) << f << " " << x << " " << y;
      }
    if (f == 5) {
      for (int y = 0; y < height - 14; ++y)
        for (int x = 20; x < width; ++x)  // L = 6: a share of 0.8
          ASSERT_FLOAT_EQ(sequence.state.light.at(x, y, 1), 0.8F * before.at(x - 3, y + 2, 1));
    }
    before = sequence.state.light;
  }
}

TEST(Svgf, HalfPixelPanIsTheBilinearMean) {  // 2.9 e
  const int side = 24;
  Sequence sequence{no_feedback()};
  for (int f = 0; f < 5; ++f) {
    auto [surfaces, signals] = panned(f, side, side, 0, 0);
    sequence(surfaces, noise(side, side, 3, uint64_t(f)));
  }
  const RowPlanes before = sequence.state.light;
  auto [surfaces, signals] = panned(5, side, side, 0.5F, -0.25F);
  sequence(surfaces, RowPlanes(side, side, 3));
  for (int y = 1; y < side; ++y)
    for (int x = 0; x + 1 < side; ++x) {
      const double mean = 0.125 * (before.at(x, y - 1, 0) + double(before.at(x + 1, y - 1, 0))) +
                          0.375 * (before.at(x, y, 0) + double(before.at(x + 1, y, 0)));
      ASSERT_NEAR(sequence.state.light.at(x, y, 0), 0.8 * mean, 1e-6);
      ASSERT_EQ(sequence.length(x, y), 6);
    }
}

/// A card (id 2, nearer) before a wall (id 1); it moves 4 pixels right each frame.
std::pair<Surfaces, RowPlanes> card_before_wall(int f) {
  const int width = 60, height = 30, left = 5 + 4 * f;
  Surfaces scene = flat_wall(width, height);
  for (int y = 8; y < 22; ++y)
    for (int x = left; x < left + 14; ++x) {
      scene.of.at(x, y, kId) = 2;
      scene.of.at(x, y, kDepth) = 5;
      scene.flow.at(x, y, 0) = -4;
    }
  return {scene, noise(width, height, 3, uint64_t(f), true)};
}

TEST(Svgf, UncoveredPixelsStartAnew) {  // 2.9 f
  Sequence sequence{no_feedback()};
  for (int f = 0; f < 6; ++f) {
    auto [surfaces, signals] = card_before_wall(f);
    sequence(surfaces, signals);
  }
  Sequence cold{no_feedback()};
  auto [surfaces, signals] = card_before_wall(5);
  cold(surfaces, signals);
  SvgfState& state = sequence.state;
  for (int y = 9; y < 21; ++y)
    for (int x = 22; x < 25; ++x) {  // what the card covered, beyond the reach of the 3x3 pixels
      ASSERT_EQ(sequence.length(x, y), 1) << x << " " << y;
      // The mean of the moments' neighbourhood may hold older pixels; what was accumulated does not.
      ASSERT_EQ(state.moments.at(x, y, 0), cold.state.moments.at(x, y, 0));
      ASSERT_EQ(state.moments.at(x, y, 1), cold.state.moments.at(x, y, 1));
    }
  EXPECT_EQ(sequence.length(30, 15), 6);  // the card
  EXPECT_EQ(sequence.length(50, 3), 6);   // the wall
}

TEST(Svgf, DollyKeepsItsHistoryWithTheChangeOfDepth) {  // 2.9 g
  const int side = 16;
  for (const bool told : {true, false}) {
    Sequence sequence;
    for (int f = 0; f < 5; ++f) {
      Surfaces wall = flat_wall(side, side);
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
          wall.of.at(x, y, kDepth) = 10 - 0.5F * float(f);
          wall.flow.at(x, y, 2) = told ? 0.5F : 0.0F;  // 5 times 10 (0 + 0.01)
        }
      sequence(wall, noise(side, side, 3, uint64_t(f)));
      EXPECT_EQ(sequence.length(8, 8), told ? float(f + 1) : 1.0F);
    }
  }
}

TEST(Svgf, IdsAndBackFacesShareNoHistory) {  // 2.9 j, k
  const int side = 12;
  const Surfaces front = flat_wall(side, side);
  Surfaces other = front, back = front;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      other.of.at(x, y, kId) = 7;
      back.of.at(x, y, kNormalZ) = -1;
    }
  for (const Surfaces& next : {other, back}) {
    Sequence sequence;
    sequence(front, noise(side, side, 3, 1));
    sequence(front, noise(side, side, 3, 2));
    EXPECT_EQ(sequence.length(5, 5), 2);
    sequence(next, noise(side, side, 3, 3));
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) ASSERT_EQ(sequence.length(x, y), 1);
  }
}

TEST(Svgf, LightThatIsSwitchedOffFadesAndIsGoneWithAntilag) {  // 2.9 i
  const int side = 24;
  const Surfaces wall = flat_wall(side, side);
  for (const double alpha : {0.2, 0.05})
    for (const std::string antilag : {"none", "clip"}) {
      SvgfSettings settings;
      settings.alpha = alpha;
      settings.antilag = antilag;
      Sequence sequence{settings};
      for (int f = 0; f < 40; ++f) sequence(wall, filled(side, side, 3, [](int, int, int) { return 2.0F; }));
      int trail = 0;  // frames of which more than 1 % is left
      for (int n = 1; n <= 100; ++n) {
        const float left = sequence(wall, RowPlanes(side, side, 3)).at(12, 12, 1);
        if (antilag == "none") {
          EXPECT_NEAR(left, 2 * std::pow(1 - alpha, n), 1e-5) << n;
        }
        if (left > 0.02F) trail = n;
      }
      EXPECT_EQ(trail + 1, antilag == "clip" ? 1 : alpha == 0.2 ? 21 : 90);
    }
}

TEST(Svgf, WithoutLevelsItIsTheAccumulatedLight) {
  SvgfSettings settings = no_feedback();
  settings.levels = 0;
  Sequence sequence{settings};
  for (int f = 0; f < 5; ++f) {
    const RowPlanes out =
        sequence(flat_wall(20, 20),
                 filled(20, 20, 3, [&](int, int x, int y) { return float((3 * x + 5 * y + f) % 11); }));
    double mean = 0;
    for (int g = 0; g <= f; ++g) mean += double((3 * 7 + 5 * 9 + g) % 11) / (f + 1);
    EXPECT_NEAR(out.at(7, 9, 1), mean, 1e-5) << f;
  }
  settings.feedback = 0;
  EXPECT_THROW(check_settings(settings), UsageError);
}

TEST(Svgf, ShortSequencesRestartLikeColdOnesAndGoOnWithAPassedState) {  // 2.9 l
  const int width = 50, height = 40;
  const auto frame = [&](int f) {
    return std::pair{busy_scene(width, height, uint64_t(f)), noise(width, height, 6, 50 + uint64_t(f), true)};
  };
  const auto run = [&](Sequence& sequence, int first, int last) {
    std::vector<RowPlanes> out;
    for (int f = first; f < last; ++f) {
      auto [surfaces, signals] = frame(f);
      out.push_back(sequence(surfaces, signals));
    }
    return out;
  };
  Sequence whole, first_half;
  const auto all = run(whole, 0, 8);
  run(first_half, 0, 4);
  Sequence second_half;
  second_half.state = first_half.state;  // its memory is another
  const auto rest = run(second_half, 4, 8);
  for (size_t f = 0; f < 4; ++f) EXPECT_TRUE(same_bits(all[4 + f], rest[f])) << f;

  Sequence cold;
  first_half.state = {};
  const auto restarted = run(first_half, 4, 8), fresh = run(cold, 4, 8);
  for (size_t f = 0; f < 4; ++f) EXPECT_TRUE(same_bits(restarted[f], fresh[f])) << f;
}

TEST(Svgf, WithoutFlowEveryFrameIsTheFirst) {
  const int side = 20;
  Sequence sequence, cold;
  Surfaces wall = flat_wall(side, side);
  wall.has_flow = false;
  sequence(wall, noise(side, side, 3, 1));
  const RowPlanes light = noise(side, side, 3, 2);
  EXPECT_TRUE(same_bits(sequence(wall, light), cold(wall, light)));
}

}  // namespace
}  // namespace ld
