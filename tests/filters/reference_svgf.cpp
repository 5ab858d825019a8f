#include "reference_svgf.h"

#include <algorithm>
#include <cmath>

namespace ld {
namespace {

DoublePlanes zeros(size_t planes, int width, int height) {
  return DoublePlanes(planes,
                      std::vector<std::vector<double>>(size_t(height), std::vector<double>(size_t(width))));
}

double luminance_at(const DoublePlanes& light, size_t signal, int x, int y) {
  const auto at = [&](size_t c) { return light[3 * signal + c][size_t(y)][size_t(x)]; };
  return 0.2126 * at(0) + 0.7152 * at(1) + 0.0722 * at(2);
}

double normals_dot(const Surfaces& a, int x, int y, const Surfaces& b, int u, int v) {
  double dot = 0;
  for (int c = kNormalX; c <= kNormalZ; ++c) dot += double(a.of.at(x, y, c)) * double(b.of.at(u, v, c));
  return dot;
}

}  // namespace

DoublePlanes ReferenceSvgf::slopes(const Surfaces& surfaces) const {
  const int width = surfaces.width(), height = surfaces.height();
  DoublePlanes out = zeros(2, width, height);
  for (int axis = 0; axis < 2; ++axis)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        double smallest = 0;
        bool any = false;
        for (const int side : {-1, 1}) {
          const int u = x + (axis == 0 ? side : 0), v = y + (axis == 1 ? side : 0);
          if (u < 0 || u >= width || v < 0 || v >= height) continue;
          if (surfaces.of.at(u, v, kId) != surfaces.of.at(x, y, kId)) continue;
          const double slope = side * (double(surfaces.of.at(u, v, kDepth)) - surfaces.of.at(x, y, kDepth));
          if (!any || std::abs(slope) < std::abs(smallest)) smallest = slope;
          any = true;
        }
        out[size_t(axis)][size_t(y)][size_t(x)] = smallest;
      }
  return out;
}

void ReferenceSvgf::accumulate(const Surfaces& surfaces, const DoublePlanes& slope,
                               const DoublePlanes& signals, const ReferenceSvgfState& previous,
                               DoublePlanes& light, DoublePlanes& moments, DoublePlanes& length) const {
  const int width = surfaces.width(), height = surfaces.height();
  const size_t count = signals.size() / 3;
  light = signals;
  moments = zeros(2 * count, width, height);
  length = zeros(1, width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      std::vector<std::array<double, 3>> taps;  // u, v, weight
      bool nearest = false;
      if (previous.surfaces && surfaces.has_flow && !std::isnan(surfaces.of.at(x, y, kId))) {
        const Surfaces& before = *previous.surfaces;
        const double slope_here =
            std::max(std::abs(slope[0][size_t(y)][size_t(x)]), std::abs(slope[1][size_t(y)][size_t(x)]));
        const auto consistent = [&](int u, int v) {
          if (u < 0 || u >= width || v < 0 || v >= height) return false;
          const double expected = double(surfaces.of.at(x, y, kDepth)) + surfaces.flow.at(x, y, 2);
          return before.of.at(u, v, kId) == surfaces.of.at(x, y, kId) &&
                 std::abs(before.of.at(u, v, kDepth) - expected) / (slope_here + 0.01 * surfaces.unit) <=
                     settings.history_depth &&
                 normals_dot(surfaces, x, y, before, u, v) >= settings.history_normal;
        };
        const double px = x + double(surfaces.flow.at(x, y, 0)), py = y + double(surfaces.flow.at(x, y, 1));
        const int left = int(std::floor(px)), top = int(std::floor(py));
        double total = 0;
        for (int v = top; v <= top + 1; ++v)
          for (int u = left; u <= left + 1; ++u) {
            const double w = (1 - std::abs(px - u)) * (1 - std::abs(py - v));
            if (w <= 0 || !consistent(u, v)) continue;
            taps.push_back({double(u), double(v), w});
            total += w;
          }
        if (total < 0.01) {
          nearest = true;
          taps.clear();
          const int nx = int(std::floor(px + 0.5)), ny = int(std::floor(py + 0.5));
          for (int v = ny - 1; v <= ny + 1; ++v)
            for (int u = nx - 1; u <= nx + 1; ++u)
              if (consistent(u, v)) taps.push_back({double(u), double(v), 1});
          total = double(taps.size());
        }
        for (auto& tap : taps) tap[2] /= total;
      }
      const auto mean = [&](const std::vector<std::vector<double>>& plane) {
        double sum = 0;
        for (const auto& tap : taps) sum += tap[2] * plane[size_t(tap[1])][size_t(tap[0])];
        return sum;
      };
      double l = 1, alpha = 1, alpha_moments = 1;
      if (!taps.empty()) {
        double before = std::floor(mean(previous.length[0]) + 1e-3);
        if (nearest) {
          before = 1e30;
          for (const auto& tap : taps)
            before = std::min(before, previous.length[0][size_t(tap[1])][size_t(tap[0])]);
        }
        l = std::min(before + 1, double(settings.longest_history));
        alpha = std::max(settings.alpha, 1 / l);
        alpha_moments = std::max(settings.alpha_moments, 1 / l);
      }
      length[0][size_t(y)][size_t(x)] = l;
      for (size_t s = 0; s < count; ++s) {
        const double luminance = luminance_at(signals, s, x, y);
        const double now[2] = {luminance, luminance * luminance};
        for (size_t m = 0; m < 2; ++m)
          moments[2 * s + m][size_t(y)][size_t(x)] =
              (1 - alpha_moments) * (taps.empty() ? 0 : mean(previous.moments[2 * s + m])) +
              alpha_moments * now[m];
        for (size_t c = 3 * s; c < 3 * s + 3; ++c)
          light[c][size_t(y)][size_t(x)] = (1 - alpha) * (taps.empty() ? 0 : mean(previous.light[c])) +
                                           alpha * signals[c][size_t(y)][size_t(x)];
      }
    }
}

double ReferenceSvgf::surface_weight(const Surfaces& surfaces, const DoublePlanes& slope, int x, int y, int u,
                                     int v) const {
  if (surfaces.of.at(u, v, kId) != surfaces.of.at(x, y, kId)) return 0;
  const double w_n = std::pow(std::max(0.0, normals_dot(surfaces, x, y, surfaces, u, v)),
                              std::pow(2.0, double(settings.normal_squarings)));
  const double z = surfaces.of.at(x, y, kDepth);
  const double gx = slope[0][size_t(y)][size_t(x)], gy = slope[1][size_t(y)][size_t(x)];
  const double explained = settings.slope == "isotropic"
                               ? std::max(std::abs(gx), std::abs(gy)) * std::hypot(u - x, v - y)
                               : std::abs(gx * (u - x) + gy * (v - y));
  const double scale = settings.sigma_depth * explained + settings.depth_tolerance * z + 1e-30;
  return w_n * std::exp(-std::abs(z - surfaces.of.at(u, v, kDepth)) / scale);
}

void ReferenceSvgf::estimate_variance(const Surfaces& surfaces, const DoublePlanes& slope,
                                      const DoublePlanes& moments, const DoublePlanes& length,
                                      DoublePlanes& light, DoublePlanes& variance) const {
  const int width = surfaces.width(), height = surfaces.height();
  const DoublePlanes in = light;
  const size_t count = light.size() / 3;
  variance = zeros(count, width, height);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const double l = length[0][size_t(y)][size_t(x)];
      const bool is_short = l < 4 && !std::isnan(surfaces.of.at(x, y, kId));
      for (size_t s = 0; s < count; ++s) {
        double m1 = moments[2 * s][size_t(y)][size_t(x)], m2 = moments[2 * s + 1][size_t(y)][size_t(x)];
        if (is_short) {
          double total = 0, sums[5] = {0, 0, 0, 0, 0};
          for (int v = std::max(y - 3, 0); v <= std::min(y + 3, height - 1); ++v)
            for (int u = std::max(x - 3, 0); u <= std::min(x + 3, width - 1); ++u) {
              const double w = u == x && v == y ? 1 : surface_weight(surfaces, slope, x, y, u, v);
              total += w;
              for (size_t c = 0; c < 3; ++c) sums[c] += w * in[3 * s + c][size_t(v)][size_t(u)];
              sums[3] += w * moments[2 * s][size_t(v)][size_t(u)];
              sums[4] += w * moments[2 * s + 1][size_t(v)][size_t(u)];
            }
          // What is lacking of four neighbours comes from all pixels with the id alike.
          const double lacking = std::max(4 - total, 0.0);
          double alike = 0, all[5] = {0, 0, 0, 0, 0};
          for (int v = std::max(y - 3, 0); v <= std::min(y + 3, height - 1); ++v)
            for (int u = std::max(x - 3, 0); u <= std::min(x + 3, width - 1); ++u) {
              if (surfaces.of.at(u, v, kId) != surfaces.of.at(x, y, kId)) continue;
              ++alike;
              for (size_t c = 0; c < 3; ++c) all[c] += in[3 * s + c][size_t(v)][size_t(u)];
              for (size_t m = 0; m < 2; ++m) all[3 + m] += moments[2 * s + m][size_t(v)][size_t(u)];
            }
          for (size_t i = 0; i < 5; ++i) sums[i] += lacking / alike * all[i];
          total += lacking;
          for (size_t c = 0; c < 3; ++c) light[3 * s + c][size_t(y)][size_t(x)] = sums[c] / total;
          m1 = sums[3] / total;
          m2 = sums[4] / total;
        }
        variance[s][size_t(y)][size_t(x)] = std::max(0.0, m2 - m1 * m1) * (is_short ? 4 / l : 1);
      }
    }
}

void ReferenceSvgf::level(const Surfaces& surfaces, const DoublePlanes& slope, int k, DoublePlanes& light,
                          DoublePlanes& variance) const {
  const int width = surfaces.width(), height = surfaces.height(), stride = 1 << k;
  const std::vector<double> taps = reference_taps("b3");
  const DoublePlanes in = light, in_variance = variance;
  const auto inside = [&](int u, int v) { return u >= 0 && u < width && v >= 0 && v < height; };
  for (size_t s = 0; s < variance.size(); ++s)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        if (std::isnan(surfaces.of.at(x, y, kId))) continue;
        double g = 0, gauss = 0;
        for (int j = -1; j <= 1; ++j)
          for (int i = -1; i <= 1; ++i) {
            if (!inside(x + i, y + j)) continue;
            const double h = (i == 0 ? 2 : 1) * (j == 0 ? 2 : 1) / 16.0;
            gauss += h;
            g += h * in_variance[s][size_t(y + j)][size_t(x + i)];
          }
        g /= gauss;
        double total = 0, squares = 0, sum[3] = {0, 0, 0}, sum_v = 0, moments[2] = {0, 0};
        for (int j = -2; j <= 2; ++j)
          for (int i = -2; i <= 2; ++i) {
            const int u = x + i * stride, v = y + j * stride;
            if (!inside(u, v)) continue;
            double w = taps[size_t(std::abs(i))] * taps[size_t(std::abs(j))];
            if (i != 0 || j != 0) {
              const double d = std::abs(luminance_at(in, s, x, y) - luminance_at(in, s, u, v));
              w *= surface_weight(surfaces, slope, x, y, u, v) *
                   std::exp(-d / (settings.sigma_light * std::sqrt(g) + 1e-10));
            }
            total += w;
            squares += w * w;
            sum_v += w * w * in_variance[s][size_t(v)][size_t(u)];
            const double luminance = luminance_at(in, s, u, v);
            moments[0] += w * luminance;
            moments[1] += w * (in_variance[s][size_t(v)][size_t(u)] + luminance * luminance);
            for (size_t c = 0; c < 3; ++c) sum[c] += w * in[3 * s + c][size_t(v)][size_t(u)];
          }
        for (size_t c = 0; c < 3; ++c) light[3 * s + c][size_t(y)][size_t(x)] = sum[c] / total;
        variance[s][size_t(y)][size_t(x)] =
            settings.variance == "moments"
                ? std::max(0.0, moments[1] / total - moments[0] / total * (moments[0] / total))
                : sum_v / (variance_slip ? squares : total * total);
      }
}

DoublePlanes ReferenceSvgf::operator()(const Surfaces& surfaces, const RowPlanes& signals,
                                       ReferenceSvgfState& state) const {
  ReferenceSvgfState next;
  const DoublePlanes slope = slopes(surfaces);
  DoublePlanes light, variance;
  accumulate(surfaces, slope, to_double(signals), state, light, next.moments, next.length);
  estimate_variance(surfaces, slope, next.moments, next.length, light, variance);
  if (settings.feedback < 0) next.light = light;
  for (int k = 0; k < settings.levels; ++k) {
    level(surfaces, slope, k, light, variance);
    if (k == settings.feedback) next.light = light;
  }
  next.surfaces = surfaces;
  state = next;
  return light;
}

}  // namespace ld
