#include "doctor/flat_windows.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

namespace ld {
namespace {

// Length of the mean of unit normals: 0.8 degrees of spread, what half floats leave of a plane and a sphere
// does not.
constexpr double kFlat = 0.9998;
// A step in depth behind equal normals (stairs, two parallel boards) leaves far more than this.
constexpr double kLargestResidual = 0.01;
constexpr int kLeastSide = 8;

/// One window: the picture's coordinates at unit depth, mean 1 / depth of each pixel, mean normal.
struct Patch {
  int side = 0;
  std::vector<double> x, y, reciprocal;
  std::array<double, 3> normal{};
};

std::optional<Patch> read_patch(const Evidence& evidence, int left, int top, int side) {
  const Frame& frame = evidence.frame;
  const double focal = *evidence.focal_pixels;
  Patch patch;
  patch.side = side;
  std::array<double, 3> sum{};
  double count = 0;
  for (int y = top; y < top + side; ++y)
    for (int x = left; x < left + side; ++x) {
      const size_t p = static_cast<size_t>(y) * static_cast<size_t>(frame.width) + static_cast<size_t>(x);
      double reciprocal = 0;
      for (int s = 0; s < frame.spp; ++s) {
        const double depth = frame.plane(s, kDepthOffset)[p];
        std::array<double, 3> n{};
        for (int c = 0; c < 3; ++c) n[static_cast<size_t>(c)] = frame.plane(s, kNormalOffset + c)[p];
        const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        if (frame.valid_plane(s)[p] == 0 || depth >= kEscapedDepth || depth <= 0 || length <= 0)
          return std::nullopt;
        for (size_t c = 0; c < 3; ++c) sum[c] += n[c] / length;
        ++count;
        reciprocal += 1 / depth;
      }
      patch.x.push_back((x + 0.5 - 0.5 * frame.width) / focal);
      patch.y.push_back((0.5 * frame.height - y - 0.5) / focal);
      patch.reciprocal.push_back(reciprocal / frame.spp);
    }
  const double length = std::sqrt(sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
  if (length < kFlat * count) return std::nullopt;
  for (size_t c = 0; c < 3; ++c) patch.normal[c] = sum[c] / length;
  return patch;
}

double mean(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// value = at_centre + x_slope (x - mean x) + y_slope (y - mean y); on a full square the three are
/// orthogonal.
struct AffineFit {
  double at_centre = 0, x_slope = 0, y_slope = 0;
};

/// Fits `values` and takes the fit out of them.
AffineFit take_affine(std::vector<double>& values, const std::vector<double>& dx,
                      const std::vector<double>& dy) {
  AffineFit fit;
  fit.at_centre = mean(values);
  fit.x_slope = dot(values, dx) / dot(dx, dx);
  fit.y_slope = dot(values, dy) / dot(dy, dy);
  for (size_t i = 0; i < values.size(); ++i)
    values[i] -= fit.at_centre + fit.x_slope * dx[i] + fit.y_slope * dy[i];
  return fit;
}

std::optional<FlatWindow> examine(const Patch& patch) {
  const double x_mean = mean(patch.x), y_mean = mean(patch.y);
  std::vector<double> dx = patch.x, dy = patch.y;
  for (double& x : dx) x -= x_mean;
  for (double& y : dy) y -= y_mean;
  std::vector<double> residual = patch.reciprocal;
  const AffineFit fit = take_affine(residual, dx, dy);
  // u = A / |(x, y, -1)|^k with an affine A: to first order k is the weight of -A ln |(x, y, -1)| in the
  // residual.
  std::vector<double> bend(residual.size());
  for (size_t i = 0; i < bend.size(); ++i)
    bend[i] = -(patch.reciprocal[i] - residual[i]) * 0.5 *
              std::log(1 + patch.x[i] * patch.x[i] + patch.y[i] * patch.y[i]);
  take_affine(bend, dx, dy);
  const double bends = dot(bend, bend);
  if (!(bends > 0) || !(fit.at_centre > 0)) return std::nullopt;
  FlatWindow window;
  window.exponent = dot(bend, residual) / bends;
  for (size_t i = 0; i < bend.size(); ++i) residual[i] -= window.exponent * bend[i];
  const double freedom = static_cast<double>(residual.size()) - 4;
  // Half floats round depth to 2^-12 of itself at worst, alike in all samples of a plane that faces the
  // camera.
  const double rounding = fit.at_centre * 1.2e-4;
  const double variance = dot(residual, residual) / freedom + rounding * rounding / 4;
  if (std::sqrt(variance) > kLargestResidual * fit.at_centre) return std::nullopt;
  window.exponent_error = std::sqrt(variance / bends);

  // The plane's normal is (-d/dx, -d/dy, value at the picture's centre) of 1 / Z, up to its length.
  const double exponent = window.exponent > 0.5 ? 1 : 0;
  std::vector<double> axial = patch.reciprocal;
  for (size_t i = 0; i < axial.size(); ++i)
    axial[i] *= std::pow(1 + patch.x[i] * patch.x[i] + patch.y[i] * patch.y[i], 0.5 * exponent);
  const AffineFit plane = take_affine(axial, dx, dy);
  const double shown[3] = {-plane.x_slope, -plane.y_slope,
                           plane.at_centre - plane.x_slope * x_mean - plane.y_slope * y_mean};
  const double length = std::sqrt(shown[0] * shown[0] + shown[1] * shown[1] + shown[2] * shown[2]);
  for (size_t c = 0; c < 3; ++c) window.normal_products[c] = shown[c] * patch.normal[c] / length;
  return window;
}

}  // namespace

std::vector<FlatWindow> flat_windows(const Evidence& evidence) {
  const Frame& frame = evidence.frame;
  std::vector<FlatWindow> windows;
  if (!evidence.focal_pixels || !frame.holds("normal") || !frame.holds("depth")) return windows;
  const int side = std::max(std::min(frame.width, frame.height) / 8, kLeastSide);
  for (int top = 0; top + side <= frame.height; top += side)
    for (int left = 0; left + side <= frame.width; left += side)
      if (const auto patch = read_patch(evidence, left, top, side))
        if (const auto window = examine(*patch)) windows.push_back(*window);
  return windows;
}

}  // namespace ld
