#include "reference_eaw.h"

#include <algorithm>
#include <cmath>

namespace ld {

DoublePlanes to_double(const RowPlanes& planes) {
  DoublePlanes out;
  for (int p = 0; p < planes.planes(); ++p) {
    out.emplace_back();
    for (int y = 0; y < planes.height(); ++y)
      out.back().emplace_back(planes.row(y, p), planes.row(y, p) + planes.width());
  }
  return out;
}

std::vector<double> reference_taps(const std::string& kernel) {
  if (kernel == "b3") return {3.0 / 8, 1.0 / 4, 1.0 / 16};
  double total = 0;
  for (int i = -2; i <= 2; ++i) total += std::exp(-i * i / 2.0);
  return {1 / total, std::exp(-0.5) / total, std::exp(-2.0) / total};
}

DoublePlanes reference_eaw_level(const Surfaces& surfaces, const DoublePlanes& in, int level,
                                 const EawSettings& settings) {
  const int width = surfaces.width(), height = surfaces.height(), stride = 1 << level;
  const std::vector<double> taps = reference_taps(settings.kernel);
  const double unit = surfaces.unit;
  const double fourths = settings.narrow ? std::pow(4.0, level) : 1;
  const auto squares = [&](int first, int count, int x, int y, int u, int v) {
    double sum = 0;
    for (int c = first; c < first + count; ++c) {
      const double d = double(surfaces.of.at(x, y, c)) - double(surfaces.of.at(u, v, c));
      sum += d * d;
    }
    return sum;
  };
  DoublePlanes out = in;
  for (size_t signal = 0; signal < in.size(); signal += 3)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        if (std::isnan(surfaces.of.at(x, y, kId))) continue;
        double total = 0, sum[3] = {0, 0, 0};
        for (int j = -2; j <= 2; ++j)
          for (int i = -2; i <= 2; ++i) {
            const int u = x + i * stride, v = y + j * stride;
            if (u < 0 || u >= width || v < 0 || v >= height) continue;
            if (surfaces.of.at(u, v, kId) != surfaces.of.at(x, y, kId)) continue;
            double d[3], light = 0;
            for (size_t c = 0; c < 3; ++c) {
              d[c] = in[signal + c][size_t(y)][size_t(x)] - in[signal + c][size_t(v)][size_t(u)];
              light += d[c] * d[c];
            }
            if (settings.range == "luminance")
              light = std::pow(0.2126 * d[0] + 0.7152 * d[1] + 0.0722 * d[2], 2);
            const bool depth = settings.place == "depth" || !surfaces.has_position;
            const double normal = squares(kNormalX, 3, x, y, u, v);
            const double place = depth ? squares(kDepth, 1, x, y, u, v) : squares(kPositionX, 3, x, y, u, v);
            const double w = std::exp(-light * fourths / settings.sigma_light) *
                             std::exp(-normal / (settings.sigma_normal * fourths)) *
                             std::exp(-place / unit / unit / settings.sigma_place);
            const double h = taps[size_t(std::abs(i))] * taps[size_t(std::abs(j))];
            total += h * w;
            for (size_t c = 0; c < 3; ++c) sum[c] += h * w * in[signal + c][size_t(v)][size_t(u)];
          }
        for (size_t c = 0; c < 3; ++c) out[signal + c][size_t(y)][size_t(x)] = sum[c] / total;
      }
  return out;
}

DoublePlanes reference_eaw(const Surfaces& surfaces, const RowPlanes& signals, const EawSettings& settings) {
  DoublePlanes planes = to_double(signals);
  for (int level = 0; level < settings.levels; ++level)
    planes = reference_eaw_level(surfaces, planes, level, settings);
  return planes;
}

double largest_difference(const RowPlanes& a, const DoublePlanes& b, double floor) {
  double largest = 0;
  for (int p = 0; p < a.planes(); ++p)
    for (int y = 0; y < a.height(); ++y)
      for (int x = 0; x < a.width(); ++x) {
        const double expected = b[size_t(p)][size_t(y)][size_t(x)];
        largest = std::max(largest, std::abs(a.at(x, y, p) - expected) / (std::abs(expected) + floor));
      }
  return largest;
}

}  // namespace ld
