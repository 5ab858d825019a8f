#include "filters/svgf.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "filter_scenes.h"
#include "ops/kernels/instruction_sets.h"
#include "reference_svgf.h"

namespace ld {
namespace {

/// A filter and its state, as a sequence needs them.
struct Sequence {
  SvgfSettings settings;
  int threads = 1;
  SvgfState state = {};
  SvgfMemory memory = {};

  RowPlanes operator()(Surfaces surfaces, const RowPlanes& signals) {
    return svgf(surfaces, signals, state, memory, settings, threads);
  }
  float length(int x, int y) const { return state.length_row(y)[x]; }
};

bool same_bits(const RowPlanes& a, const RowPlanes& b) {
  for (int y = 0; y < a.height(); ++y)
    for (int p = 0; p < a.planes(); ++p)
      if (!std::equal(a.row(y, p), a.row(y, p) + a.width(), b.row(y, p))) return false;
  return true;
}

SvgfSettings no_feedback() {
  SvgfSettings settings;
  settings.feedback = -1;
  settings.antilag = "none";
  return settings;
}

/// The accumulated light (before the levels) of frames of a scene; feedback is off, so it is the state's.
template <class Scene>
std::vector<RowPlanes> accumulated(int frames, const SvgfSettings& settings, const Scene& scene) {
  Sequence sequence{settings};
  std::vector<RowPlanes> out;
  for (int f = 0; f < frames; ++f) {
    auto [surfaces, signals] = scene(f);
    sequence(surfaces, signals);
    out.push_back(sequence.state.light);
  }
  return out;
}

TEST(Svgf, ConstantSurfacesStayAsTheyAre) {  // 2.9 a
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 90}, {40, 30}}) {
    Surfaces scene = busy_scene(width, height, 3);
    for (int p = 0; p < 3; ++p)
      for (int y = 0; y < height; ++y) std::fill_n(scene.flow.row(y, p), width, 0.0F);
    const RowPlanes light = filled(width, height, 6, [&](int p, int x, int y) {
      return scene.of.at(x, y, kId) == scene.of.at(x, y, kId) ? 1 + scene.of.at(x, y, kId) + 0.1F * float(p)
                                                              : 0.0F;
    });
    Sequence sequence;
    for (int f = 0; f < 7; ++f) {
      const RowPlanes out = sequence(scene, light);
      for (int s = 0; s < 2; ++s)
        for (int c = 0; c < 3; ++c)
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
              ASSERT_NEAR(out.at(x, y, 4 * s + c), light.at(x, y, 3 * s + c),
                          2e-6 * light.at(x, y, 3 * s + c));
    }
  }
}

TEST(Svgf, TextureWithoutNoiseComesBackAsTheFirstFramesFade) {  // 2.9 a
  const int side = 40;
  const RowPlanes light =
      filled(side, side, 3, [](int, int x, int y) { return (x / 3 + y / 3) % 2 == 0 ? 1.0F : 0.25F; });
  Sequence sequence;
  sequence.settings.antilag = "none";
  double at_four = 0;
  for (int f = 1; f <= 70; ++f) {
    const RowPlanes out = sequence(flat_wall(side, side), light);
    double error = 0;
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x)
        error = std::max(error, double(std::abs(out.at(x, y, 0) - light.at(x, y, 0))));
    if (f == 4) at_four = error;
    // Frames 1 to 3 are blurred; from then on each frame is one fifth of what comes in.
    if (f > 5 && f <= 50) {
      EXPECT_LE(error, at_four * std::pow(0.8, f - 5) + 1e-6) << f;
    }
    if (f == 70) {
      EXPECT_LE(error, 1e-6);
    }
  }
  EXPECT_GT(at_four, 0.05);
}

TEST(Svgf, VarianceFallsAsTheHistoryGrows) {  // 2.9 b
  const int side = 160;
  const Surfaces wall = flat_wall(side, side);
  for (const double alpha : {0.2, 0.05}) {
    SvgfSettings settings = no_feedback();
    settings.alpha = settings.alpha_moments = alpha;
    SvgfState previous;
    RowPlanes slopes, light, moments;
    depth_slopes(wall, slopes, 1);
    const int frames = 150;
    std::vector<double> variances;
    double late = 0;
    for (int f = 0; f < frames; ++f) {
      accumulate(wall, slopes, noise(side, side, 3, uint64_t(f)), previous, settings, light, moments, 1);
      const double variance = spread(light, 0).variance;
      variances.push_back(variance);
      if (f >= 100) late += variance / 50;
      std::swap(previous.light, light);
      std::swap(previous.moments, moments);
      previous.surfaces = wall;
    }
    const int averages = alpha == 0.2 ? 5 : 20;
    for (int f = 0; f < averages; ++f) EXPECT_NEAR(variances[size_t(f)], 1.0 / (f + 1), 0.05 / (f + 1)) << f;
    EXPECT_NEAR(late, alpha / (2 - alpha), 0.05 * alpha / (2 - alpha));  // 0.1111, 0.02564
  }
}

TEST(Svgf, IsUnbiasedOverSeeds) {  // 2.9 c
  const int side = 96;
  const Surfaces wall = flat_wall(side, side);
  SvgfSettings settings = no_feedback();
  double sum = 0, count = 0;
  for (uint64_t seed = 0; seed < 8; ++seed) {
    const auto frames = accumulated(6, settings, [&](int f) {
      return std::pair{wall, noise(side, side, 3, 100 * seed + uint64_t(f), true)};
    });
    sum += spread(frames.back(), 1).mean;
    ++count;
  }
  // Exponential noise of mean and deviation 1: the mean of 8 * 96^2 pixels, each of variance about 0.2.
  EXPECT_NEAR(sum / count, 1, 4 * std::sqrt(0.2 / (8.0 * side * side)));
}

TEST(Svgf, VarianceFollowsTheIndependentTapsOnAFlatWall) {  // 2.9 d
  const int side = 160;
  const Surfaces wall = flat_wall(side, side);
  SvgfSettings settings;
  settings.sigma_light = 1e30;
  RowPlanes slopes, out;
  depth_slopes(wall, slopes, 1);
  RowPlanes in =
      filled(side, side, 4, [](int p, int x, int y) { return p == 3 ? 3.0F : float((x * y) % 7); });
  double expected = 3;
  for (int level = 0; level < 5; ++level) {
    svgf_level(wall, slopes, in, out, level, settings, 1);
    std::swap(in, out);
    expected *= 0.07476806640625;  // ((6^2 + 2 4^2 + 2 1^2) / 16^2)^2
    EXPECT_NEAR(in.at(side / 2, side / 2, 3), expected, 1e-5 * expected) << level;
  }
}

TEST(Svgf, VarianceOfMomentsIsThatOfTheLightUnderTheFilter) {
  // Of taps that are alike it stays, of white noise with hardly any variance of its own it becomes that of the
  // noise.
  SvgfSettings settings = no_feedback();
  settings.variance = "moments";
  settings.sigma_light = 1e20;
  const int side = 256;
  const Surfaces wall = flat_wall(side, side);
  RowPlanes slopes, out;
  depth_slopes(wall, slopes, 1);
  RowPlanes light(side, side, 4);
  fill(light, [](int p, int, int) { return p == 3 ? 0.25F : 2.0F; });
  svgf_level(wall, slopes, light, out, 0, settings, 1);
  EXPECT_NEAR(out.at(100, 100, 3), 0.25, 1e-6);
  const RowPlanes white = noise(side, side, 3, 5);
  fill(light, [&](int p, int x, int y) { return p == 3 ? 1e-12F : white.at(x, y, 0); });
  double input = 0, variance = 0, mean = 0;
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) mean += white.at(x, y, 0) / double(side * side);
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) input += std::pow(white.at(x, y, 0) - mean, 2) / double(side * side);
  svgf_level(wall, slopes, light, out, 0, settings, 1);
  for (int y = 4; y < side - 4; ++y)
    for (int x = 4; x < side - 4; ++x) variance += out.at(x, y, 3) / double((side - 8) * (side - 8));
  // Taps that are independent are a sample with weights: 1 - sum h^2 of the variance, sum h^2 = 0.074768.
  EXPECT_NEAR(variance / input, 1 - 0.074768, 0.03);
}

TEST(Svgf, WithTheVarianceDividedBySquaresItNeverFalls) {  // 2.9 d, the slip
  ReferenceSvgf slipped;
  slipped.settings.sigma_light = 1e30;
  slipped.variance_slip = true;
  const Surfaces wall = flat_wall(24, 24);
  DoublePlanes light = to_double(noise(24, 24, 3, 1)),
               variance = to_double(filled(24, 24, 1, [](int, int, int) { return 3.0F; }));
  for (int level = 0; level < 3; ++level) slipped.level(wall, slipped.slopes(wall), level, light, variance);
  EXPECT_NEAR(variance[0][12][12], 3, 1e-9);
}

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

TEST(Svgf, AWireBorrowsTheLightOfItsOtherPixelsUntilItHasAHistory) {
  // A wire of one pixel whose normals have nothing in common, and a dot that nothing resembles; of four
  // samples one brings light.
  const int width = 31, height = 400, column = 10;
  Surfaces scene = flat_wall(width, height);
  RowPlanes signals = filled(width, height, 3, [](int, int, int) { return 1.0F; });
  const RowPlanes chance = noise(1, height, 3, 5);
  double noisy = 0;
  for (int y = 0; y < height; ++y) {
    scene.of.at(column, y, kId) = 2;
    scene.of.at(column, y, kNormalX + y % 3) = 1;
    if (y % 3 != 2) scene.of.at(column, y, kNormalZ) = 0;
    const float lit = chance.at(0, y, 0) > 0.6745F ? 4.0F : 0.0F;
    noisy += (lit - 1.0) * (lit - 1.0) / height;
    for (int c = 0; c < 3; ++c) signals.at(column, y, c) = lit;
  }
  scene.of.at(20, 20, kId) = 3;
  for (int c = 0; c < 3; ++c) signals.at(20, 20, c) = 0.5F;
  SvgfSettings settings = no_feedback();
  RowPlanes slopes, light, moments, spare;
  depth_slopes(scene, slopes, 1);
  accumulate(scene, slopes, signals, {}, settings, light, moments, 1);
  estimate_variance(scene, slopes, moments, light, spare, settings, 1);
  double left = 0;
  for (int y = 3; y + 3 < height; ++y) {
    left += std::pow(double(light.at(column, y, 0)) - 1, 2) / (height - 6);
    ASSERT_FLOAT_EQ(light.at(column - 1, y, 0), 1) << "nothing reaches another surface";
  }
  // w = 1 of its own and of those with its normal, three pixels away (3 of 7 in all): 1 of 4 is lacking,
  // shared among 7.
  const double own = (1 + 1.0 / 7) / 4, others = (1.0 / 7) / 4;
  EXPECT_NEAR(left / noisy, 3 * own * own + 4 * others * others, 0.06);
  EXPECT_EQ(light.at(20, 20, 0), 0.5F);
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

TEST(Svgf, ThreadsAndTilesHaveTheSameBits) {  // 2.9 m
  const int width = 150, height = 230;
  for (const std::string antilag : {"none", "clip"}) {
    SvgfSettings settings;
    settings.antilag = antilag;
    Sequence one{settings, 1}, three{settings, 3}, upper{settings, 1};
    for (int f = 0; f < 5; ++f) {
      Surfaces scene = busy_scene(width, height, uint64_t(f));
      for (int y = 0; y < height; ++y) std::fill_n(scene.flow.row(y, 1), width, 0.0F);
      const RowPlanes signals = noise(width, height, 3, 9 + uint64_t(f), true);
      const RowPlanes a = one(scene, signals);
      ASSERT_TRUE(same_bits(a, three(scene, signals)));
      // A strip of the picture: after f frames its history is that of the whole but for 5 rows a frame (7x7
      // and level 0 reach 3 + 2), and the filter reaches 62 + 3 + 1.
      const RowPlanes part = upper(cut(scene, 0, 0, width, 160), cut(signals, 0, 0, width, 160));
      for (int p = 0; p < 4; ++p)
        for (int y = 0; y < 160 - 66 - 6 * (f + 1); ++y)
          ASSERT_TRUE(std::equal(a.row(y, p), a.row(y, p) + width, part.row(y, p))) << f << " " << y;
    }
  }
}

TEST(Svgf, IsTheEquationsInDoubleOnEveryInstructionSet) {  // 2.9 n
  const int width = 45, height = 37;
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const std::string slope : {"plane", "isotropic"})
      for (const int64_t feedback : {-1, 0, 1}) {
        ReferenceSvgf reference;
        reference.settings.antilag = "none";
        reference.settings.variance = feedback == 1 ? "moments" : "taps";
        reference.settings.slope = slope;
        reference.settings.feedback = feedback;
        ReferenceSvgfState state;
        Sequence sequence{reference.settings};
        for (int f = 0; f < 8; ++f) {
          const Surfaces scene = busy_scene(width, height, uint64_t(f));
          const RowPlanes signals = noise(width, height, 6, 77 + uint64_t(f), true);
          const DoublePlanes expected = reference(scene, signals, state);
          const RowPlanes out = sequence(scene, signals);
          RowPlanes colours(width, height, 6);
          fill(colours, [&](int p, int x, int y) { return out.at(x, y, p / 3 * 4 + p % 3); });
          ASSERT_LE(largest_difference(colours, expected, 1e-3), 1e-4)
              << set << slope << feedback << " " << f;
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
              ASSERT_EQ(sequence.length(x, y), state.length[0][size_t(y)][size_t(x)]) << f;
        }
      }
  }
  use_instruction_set("");
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

TEST(Svgf, ExtremeLightAndGuidesStayFinite) {
  const int width = 40, height = 20;
  for (const float value : {0.0F, 1e-45F, 1e-38F, 65504.0F, 1e18F, 1e37F, -3.0F})
    for (const std::string antilag : {"none", "clip"}) {
      SvgfSettings settings;
      settings.antilag = antilag;
      settings.variance = antilag == "none" ? "moments" : "taps";
      Sequence sequence{settings};
      for (int f = 0; f < 6; ++f) {
        Surfaces scene = busy_scene(width, height, uint64_t(f));
        scene.flow.at(3, 3, 0) = 65504;
        scene.flow.at(4, 3, 1) = -65504;
        scene.flow.at(5, 3, 1) = std::numeric_limits<float>::quiet_NaN();
        scene.of.at(6, 6, kDepth) = 0;
        scene.of.at(7, 6, kDepth) = 65504;
        const RowPlanes out = sequence(scene, filled(width, height, 3, [&](int, int x, int y) {
                                         return (x + y + f) % 3 == 0 ? value : 0.0F;
                                       }));
        for (int p = 0; p < 3; ++p)
          for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x) ASSERT_TRUE(std::isfinite(out.at(x, y, p))) << value << " " << f;
      }
    }
}

TEST(Svgf, RefusesFeedbackBehindTheLastLevel) {
  Sequence sequence;
  sequence.settings.levels = 2;
  sequence.settings.feedback = 2;
  EXPECT_THROW(sequence(flat_wall(4, 4), RowPlanes(4, 4, 3)), UsageError);
}

}  // namespace
}  // namespace ld
