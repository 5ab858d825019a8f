#include "filters/eaw.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "filter_scenes.h"
#include "ops/kernels/instruction_sets.h"
#include "reference_eaw.h"

namespace ld {
namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();

EawSettings wavelet_alone(const std::string& kernel = "b3") {
  EawSettings settings;
  settings.kernel = kernel;
  settings.sigma_light = settings.sigma_normal = settings.sigma_place = kInfinite;
  return settings;
}

RowPlanes run(const Surfaces& surfaces, RowPlanes signals, const EawSettings& settings, int threads = 1) {
  RowPlanes spare;
  eaw(surfaces, signals, spare, settings, threads);
  return signals;
}

TEST(Eaw, ConstantLightStaysAtAnySize) {
  for (const auto& [width, height] : {std::pair{1, 1}, {3, 200}, {200, 3}, {17, 31}, {64, 64}}) {
    const RowPlanes out = run(flat_wall(width, height, 0.01F),
                              filled(width, height, 6, [](int p, int, int) { return 0.3F + float(p); }), {});
    for (int p = 0; p < 6; ++p)
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) ASSERT_NEAR(out.at(x, y, p), 0.3 + p, 1e-6 * (0.3 + p));
  }
}

TEST(Eaw, ImpulseGivesTheTapsOfTheCascade) {
  const int side = 205, middle = 102;  // no tap that counts leaves the picture
  for (const std::string kernel : {"b3", "gauss"}) {
    const EawSettings settings = wavelet_alone(kernel);
    const std::vector<double> taps = reference_taps(kernel);
    // One dimension is enough: the cascade is the outer product of itself.
    std::vector<double> line(side, 0.0);
    line[middle] = 1;
    RowPlanes in =
        filled(side, side, 3, [&](int, int x, int y) { return float(x == middle && y == middle); });
    RowPlanes out(side, side, 3);
    const Surfaces wall = flat_wall(side, side);
    for (int level = 0; level < 5; ++level) {
      std::vector<double> next(side, 0.0);
      for (int x = 0; x < side; ++x)
        for (int i = -2; i <= 2; ++i) {
          const int q = x + i * (1 << level);
          if (q >= 0 && q < side) next[size_t(x)] += taps[size_t(std::abs(i))] * line[size_t(q)];
        }
      line = next;
      eaw_level(wall, in, out, level, settings, 2);
      std::swap(in, out);
      double energy = 0;
      int support = 0;
      for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
          energy += in.at(x, y, 1);
          support += y == middle && in.at(x, y, 1) > 0;
          ASSERT_NEAR(in.at(x, y, 1), line[size_t(x)] * line[size_t(y)], 1e-7) << kernel << level;
        }
      EXPECT_NEAR(energy, 1, 1e-5);
      EXPECT_EQ(support, 4 * ((2 << level) - 1) + 1);  // 5, 13, 29, 61, 125
    }
  }
}

TEST(Eaw, WhiteNoiseLosesTheVarianceOfTheCascade) {
  const int side = 512;
  const double expected[2][5] = {{0.074768, 0.015246, 0.003643, 0.000901, 0.000225},
                                 {0.082547, 0.016739, 0.003994, 0.000987, 0.000246}};
  for (int kernel = 0; kernel < 2; ++kernel) {
    // A thousand independent patches of the widest kernel are needed for 5 %: several pictures.
    double variance[5] = {}, white = 0;
    const int pictures = 12;
    for (int n = 0; n < pictures; ++n) {
      RowPlanes in = noise(side, side, 6, uint64_t(100 * kernel + n)), out(side, side, 6);
      const Surfaces wall = flat_wall(side, side);
      for (int p = 0; p < 6; ++p) white += spread(in, p).variance;
      for (int level = 0; level < 5; ++level) {
        eaw_level(wall, in, out, level, wavelet_alone(kernel == 0 ? "b3" : "gauss"), 2);
        std::swap(in, out);
        for (int p = 0; p < 6; ++p) {
          const Spread s = spread(in, p, 62);
          variance[level] += s.variance + s.mean * s.mean;  // the true mean is 0
        }
      }
    }
    for (int level = 0; level < 5; ++level)
      EXPECT_NEAR(variance[level] / white, expected[kernel][level], 0.05 * expected[kernel][level])
          << kernel << " after level " << level;
  }
}

/// Left and right half apart equal the whole: nothing crossed.
void expect_halves_apart(const Surfaces& scene, const EawSettings& settings) {
  const int width = scene.width(), height = scene.height(), half = width / 2;
  const RowPlanes signals = noise(width, height, 3, 5, true);
  const RowPlanes whole = run(scene, signals, settings);
  for (const int first : {0, half}) {
    const RowPlanes part =
        run(cut(scene, first, 0, half, height), cut(signals, first, 0, half, height), settings);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < half; ++x) ASSERT_EQ(whole.at(first + x, y, 1), part.at(x, y, 1)) << x << " " << y;
  }
}

TEST(Eaw, SurfacesOfDifferentIdNeverMix) {
  Surfaces scene = flat_wall(80, 50);
  for (int y = 0; y < 50; ++y)
    for (int x = 40; x < 80; ++x) scene.of.at(x, y, kId) = 2;
  expect_halves_apart(scene, {});
}

TEST(Eaw, OppositeNormalsNeverMix) {
  Surfaces scene = flat_wall(80, 50);
  for (int y = 0; y < 50; ++y)
    for (int x = 40; x < 80; ++x) scene.of.at(x, y, kNormalZ) = -1;
  EawSettings settings;
  settings.sigma_normal = 0.02;  // exp(-4 / 0.02) = exp(-200)
  expect_halves_apart(scene, settings);
}

TEST(Eaw, StaysWithinTheRangeOfItsInput) {
  const int width = 60, height = 40;
  const RowPlanes signals = noise(width, height, 3, 9, true);
  EawSettings settings;
  settings.levels = 1;
  const RowPlanes out = run(busy_scene(width, height, 3), signals, settings);
  for (int p = 0; p < 3; ++p)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        float low = 1e30F, high = -1e30F;
        for (int v = std::max(y - 2, 0); v <= std::min(y + 2, height - 1); ++v)
          for (int u = std::max(x - 2, 0); u <= std::min(x + 2, width - 1); ++u) {
            low = std::min(low, signals.at(u, v, p));
            high = std::max(high, signals.at(u, v, p));
          }
        ASSERT_GE(out.at(x, y, p), low * (1 - 1e-6F));
        ASSERT_LE(out.at(x, y, p), high * (1 + 1e-6F));
      }
}

TEST(Eaw, ScalesWithTheLightWhereItsDifferencesDoNotCount) {
  const Surfaces scene = busy_scene(50, 30, 4);
  EawSettings settings;
  settings.sigma_light = kInfinite;
  const RowPlanes signals = noise(50, 30, 3, 6);
  const RowPlanes once = run(scene, signals, settings);
  const RowPlanes eightfold =
      run(scene, filled(50, 30, 3, [&](int p, int x, int y) { return 8 * signals.at(x, y, p); }), settings);
  for (int y = 0; y < 30; ++y)
    for (int x = 0; x < 50; ++x) ASSERT_EQ(8 * once.at(x, y, 2), eightfold.at(x, y, 2));
}

/// The picture turned: out(x, y) = in(map(x, y)).
template <class Map>
void expect_commutes(int width, int height, const Map& map) {
  const Surfaces scene = busy_scene(40, 28, 8);
  const RowPlanes signals = noise(40, 28, 6, 7, true);
  Surfaces turned(width, height);
  turned.unit = scene.unit;
  turned.has_position = true;
  fill(turned.of, [&](int p, int x, int y) { return scene.of.at(map(x, y).first, map(x, y).second, p); });
  const RowPlanes turned_signals = filled(width, height, 6, [&](int p, int x, int y) {
    return signals.at(map(x, y).first, map(x, y).second, p);
  });
  const RowPlanes first = run(scene, signals, {}), second = run(turned, turned_signals, {});
  for (int p = 0; p < 6; ++p)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const float expected = first.at(map(x, y).first, map(x, y).second, p);
        ASSERT_NEAR(second.at(x, y, p), expected, 2e-6 * expected + 1e-7);
      }
}

TEST(Eaw, TurnsAndFlipsWithThePicture) {
  expect_commutes(28, 40, [](int x, int y) { return std::pair{y, 27 - x}; });
  expect_commutes(40, 28, [](int x, int y) { return std::pair{39 - x, y}; });
  expect_commutes(40, 28, [](int x, int y) { return std::pair{x, 27 - y}; });
}

TEST(Eaw, IsTheEquationInDoubleOnEveryInstructionSet) {
  const int width = 75, height = 61;
  const Surfaces scene = busy_scene(width, height, 1);
  const RowPlanes signals = noise(width, height, 6, 2, true);
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const std::string range : {"colour", "luminance"})
      for (const std::string place : {"position", "depth"})
        for (const bool narrow : {false, true})
          for (const std::string kernel : {"b3", "gauss"}) {
            EawSettings settings;
            settings.range = range;
            settings.place = place;
            settings.narrow = narrow;
            settings.kernel = kernel;
            settings.sigma_light = 4;
            EXPECT_LE(largest_difference(run(scene, signals, settings),
                                         reference_eaw(scene, signals, settings), 1e-6),
                      1e-5)
                << set << range << place << narrow << kernel;
          }
  }
  use_instruction_set("");
}

TEST(Eaw, TilesAndThreadsHaveTheSameBits) {
  const int width = 300, height = 220, halo = 62;
  const Surfaces scene = busy_scene(width, height, 11);
  const RowPlanes signals = noise(width, height, 6, 12, true);
  const RowPlanes whole = run(scene, signals, {});
  for (const int threads : {2, 3, 7}) {
    const RowPlanes again = run(scene, signals, {}, threads);
    for (int y = 0; y < height; ++y)
      for (int p = 0; p < 6; ++p)
        ASSERT_TRUE(std::equal(whole.row(y, p), whole.row(y, p) + width, again.row(y, p)));
  }
  for (const int tile : {50, 97})
    for (int y0 = 0; y0 < height; y0 += tile)
      for (int x0 = 0; x0 < width; x0 += tile) {
        const int left = std::max(x0 - halo, 0), top = std::max(y0 - halo, 0);
        const int right = std::min(x0 + tile + halo, width), bottom = std::min(y0 + tile + halo, height);
        const RowPlanes part = run(cut(scene, left, top, right - left, bottom - top),
                                   cut(signals, left, top, right - left, bottom - top), {});
        for (int y = y0; y < std::min(y0 + tile, height); ++y)
          for (int x = x0; x < std::min(x0 + tile, width); ++x)
            ASSERT_EQ(part.at(x - left, y - top, 4), whole.at(x, y, 4)) << x << " " << y;
      }
}

TEST(Eaw, ExtremeLightStaysFinite) {
  const Surfaces scene = busy_scene(40, 20, 2);
  for (const float value : {0.0F, 1e-45F, 1e-38F, 65504.0F, 1e37F, -3.0F})
    for (const double sigma : {1e-12, 64.0, kInfinite}) {
      EawSettings settings;
      settings.sigma_light = sigma;
      const RowPlanes out =
          run(scene, filled(40, 20, 3, [&](int, int x, int y) { return (x + y) % 2 == 0 ? value : -value; }),
              settings);
      for (int y = 0; y < 20; ++y)
        for (int x = 0; x < 40; ++x) {
          ASSERT_TRUE(std::isfinite(out.at(x, y, 0))) << value;
          ASSERT_LE(std::abs(out.at(x, y, 0)), std::abs(value) * (1 + 1e-6F));
        }
    }
}

}  // namespace
}  // namespace ld
