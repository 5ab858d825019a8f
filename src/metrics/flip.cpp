#include "metrics/flip.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/pi.h"
#include "core/tone_map.h"
#include "metrics/image_pair.h"

namespace ld {
namespace {

using Plane = std::vector<double>;
using Colour = std::array<double, 3>;

constexpr double kColourExponent = 0.7, kFeatureExponent = 0.5;  // q_c, q_f
constexpr double kColourShare = 0.4, kColourShown = 0.95;        // p_c, p_t
constexpr double kFeatureWidth = 0.082;                          // degrees
constexpr double kShownMost = 0.85;                              // t of [A21]
constexpr double kLeastLuminance = 1.0 / (1 << 23);

/// A Gaussian of the contrast sensitivity of one channel: a sqrt(pi / b) exp(-pi^2 d^2 / b), d in degrees
/// ([A20], table 1).
struct Sensitivity {
  double a, b;
};
constexpr Sensitivity kAchromatic = {1, 0.0047}, kRedGreen = {1, 0.0053}, kBlueYellow = {34.1, 0.04},
                      kBlueYellowNarrow = {13.5, 0.025};

using Matrix = std::array<Colour, 3>;  // of rows

Colour operator*(const Matrix& m, const Colour& v) {
  Colour result{};
  for (size_t i = 0; i < 3; ++i) result[i] = m[i][0] * v[0] + m[i][1] * v[1] + m[i][2] * v[2];
  return result;
}

/// By Cramer's rule: its columns are cross products of the rows.
Matrix inverse(const Matrix& m) {
  Matrix result{};
  double determinant = 0;
  for (size_t i = 0; i < 3; ++i) {
    const Colour &a = m[(i + 1) % 3], &b = m[(i + 2) % 3];
    const Colour cross = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    if (i == 0) determinant = m[0][0] * cross[0] + m[0][1] * cross[1] + m[0][2] * cross[2];
    for (size_t k = 0; k < 3; ++k) result[k][i] = cross[k];
  }
  for (Colour& row : result)
    for (double& x : row) x /= determinant;
  return result;
}

/// Linear RGB to XYZ, both of white being 1, and back, from the chromaticities of sRGB (IEC 61966-2-1).
struct Primaries {
  Matrix to_xyz, to_rgb;

  Primaries() {
    constexpr double x[4] = {0.64, 0.3, 0.15, 0.3127}, y[4] = {0.33, 0.6, 0.06, 0.329};  // R, G, B, white
    Matrix columns{};
    for (size_t k = 0; k < 3; ++k)
      for (size_t i = 0; i < 3; ++i) columns[i][k] = i == 0 ? x[k] : i == 1 ? y[k] : 1 - x[k] - y[k];
    const Colour white = {x[3] / y[3], 1, (1 - x[3] - y[3]) / y[3]};
    const Colour strengths = inverse(columns) * white;
    for (size_t i = 0; i < 3; ++i)
      for (size_t k = 0; k < 3; ++k) to_xyz[i][k] = columns[i][k] * strengths[k] / white[i];
    to_rgb = inverse(to_xyz);
  }
};

const Primaries& primaries() {
  static const Primaries srgb;
  return srgb;
}

/// L*a*b* with the Hunt effect: chroma grows with luminance ([A20], section 4.1.2).
Colour hunt_lab(const Colour& rgb) {
  const auto curve = [](double t) {
    constexpr double delta = 6.0 / 29;
    return t > delta * delta * delta ? std::cbrt(t) : t / (3 * delta * delta) + 4.0 / 29;
  };
  const Colour xyz = primaries().to_xyz * rgb;
  const double x = curve(xyz[0]), y = curve(xyz[1]), z = curve(xyz[2]);
  const double lightness = 116 * y - 16, hunt = 0.01 * lightness;
  return {lightness, 500 * (x - y) * hunt, 200 * (y - z) * hunt};
}

/// HyAB, the distance of large colour differences, to the power of q_c.
double colour_difference(const Colour& a, const Colour& b) {
  return std::pow(std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]), kColourExponent);
}

/// The largest difference, green against blue, is 1; below p_c of it, differences fill [0, p_t].
double redistributed(double difference) {
  static const double largest = colour_difference(hunt_lab({0, 1, 0}), hunt_lab({0, 0, 1}));
  const double bend = kColourShare * largest;
  const double shown = difference < bend
                           ? kColourShown / bend * difference
                           : kColourShown + (difference - bend) / (largest - bend) * (1 - kColourShown);
  return std::min(shown, 1.0);
}

/// Of a kernel along one axis the weights from -radius to radius, those above 0 and those below made to sum
/// to 1 and -1.
template <class F>
Plane weights_of(int radius, F&& value) {
  Plane weights;
  double above = 0, below = 0;
  for (int i = -radius; i <= radius; ++i) {
    weights.push_back(value(static_cast<double>(i)));
    (weights.back() > 0 ? above : below) += std::abs(weights.back());
  }
  for (double& weight : weights) weight /= weight > 0 ? above : std::max(below, 1e-300);
  return weights;
}

/// Convolution of the rows with `across` and of the columns with `down`; the border's pixels stand for those
/// outside.
Plane convolve(const Plane& in, int width, int height, const Plane& across, const Plane& down) {
  const auto clamped = [](int i, int size) { return std::clamp(i, 0, size - 1); };
  const int rx = static_cast<int>(across.size()) / 2, ry = static_cast<int>(down.size()) / 2;
  Plane rows(in.size()), result(in.size()), wide(size_t(width + 2 * rx));
  for (int y = 0; y < height; ++y) {
    const double* source = in.data() + size_t(y) * size_t(width);
    for (int x = -rx; x < width + rx; ++x) wide[size_t(x + rx)] = source[clamped(x, width)];
    double* out = rows.data() + size_t(y) * size_t(width);
    for (size_t k = 0; k < across.size(); ++k)
      for (int x = 0; x < width; ++x) out[x] += across[k] * wide[size_t(x) + k];
  }
  for (int y = 0; y < height; ++y) {
    double* out = result.data() + size_t(y) * size_t(width);
    for (int k = -ry; k <= ry; ++k) {
      const double* source = rows.data() + size_t(clamped(y + k, height)) * size_t(width);
      const double weight = down[size_t(k + ry)];
      for (int x = 0; x < width; ++x) out[x] += weight * source[x];
    }
  }
  return result;
}

/// What the eye resolves of one channel: its plane through the Gaussians of its sensitivity. All channels use
/// the reach of the widest.
Plane resolved(const Plane& plane, int width, int height, const std::vector<Sensitivity>& parts) {
  const int radius =
      static_cast<int>(std::ceil(3 * std::sqrt(kBlueYellow.b / (2 * kPi * kPi)) * kFlipPixelsPerDegree));
  std::vector<double> shares;
  for (const Sensitivity& part : parts) {
    double sum = 0;
    for (int i = -radius; i <= radius; ++i)
      sum += std::exp(-kPi * kPi * i * i / (kFlipPixelsPerDegree * kFlipPixelsPerDegree * part.b));
    shares.push_back(part.a * std::sqrt(kPi / part.b) * sum * sum);
  }
  const double total = std::accumulate(shares.begin(), shares.end(), 0.0);
  Plane result(plane.size());
  for (size_t i = 0; i < parts.size(); ++i) {
    const Plane weights = weights_of(radius, [&](double x) {
      return std::exp(-kPi * kPi * x * x / (kFlipPixelsPerDegree * kFlipPixelsPerDegree * parts[i].b));
    });
    const Plane part = convolve(plane, width, height, weights, weights);
    for (size_t p = 0; p < result.size(); ++p) result[p] += shares[i] / total * part[p];
  }
  return result;
}

/// What of a picture [A20] compares: the colours that the eye resolves, and how strong edges and points are.
struct Seen {
  std::vector<Colour> colours;
  Plane edges, points;
};

Seen see(const Plane& rgb, int width, int height) {
  const size_t count = size_t(width) * size_t(height);
  Plane luminance(count), red_green(count), blue_yellow(count);
  for (size_t p = 0; p < count; ++p) {
    const Colour xyz = primaries().to_xyz * Colour{rgb[p], rgb[count + p], rgb[2 * count + p]};
    luminance[p] = xyz[1];
    red_green[p] = xyz[0] - xyz[1];
    blue_yellow[p] = xyz[1] - xyz[2];
  }
  Seen seen;
  // YCxCz is linear in these three, so filtering them is filtering YCxCz.
  const Plane y = resolved(luminance, width, height, {kAchromatic});
  const Plane cx = resolved(red_green, width, height, {kRedGreen});
  const Plane cz = resolved(blue_yellow, width, height, {kBlueYellow, kBlueYellowNarrow});
  for (size_t p = 0; p < count; ++p) {
    Colour colour = primaries().to_rgb * Colour{y[p] + cx[p], y[p], y[p] - cz[p]};
    for (double& channel : colour) channel = std::clamp(channel, 0.0, 1.0);
    seen.colours.push_back(hunt_lab(colour));
  }

  const double sigma = 0.5 * kFeatureWidth * kFlipPixelsPerDegree;
  const int radius = static_cast<int>(std::ceil(3 * sigma));
  const auto gauss = [&](double x) { return std::exp(-x * x / (2 * sigma * sigma)); };
  const Plane smooth = weights_of(radius, gauss);
  const Plane slope = weights_of(radius, [&](double x) { return -x * gauss(x); });
  const Plane bend = weights_of(radius, [&](double x) { return (x * x / (sigma * sigma) - 1) * gauss(x); });
  const auto strength = [&](const Plane& kernel) {
    Plane across = convolve(luminance, width, height, kernel, smooth);
    const Plane down = convolve(luminance, width, height, smooth, kernel);
    for (size_t p = 0; p < count; ++p) across[p] = std::hypot(across[p], down[p]);
    return across;
  };
  seen.edges = strength(slope);
  seen.points = strength(bend);
  return seen;
}

/// The filmic curve of the Academy Color Encoding System as Narkowicz fits it, with the exposure 0.6 before.
struct Aces {
  static constexpr double a = 0.6 * 0.6 * 2.51, b = 0.6 * 0.03, c = 0.6 * 0.6 * 2.43, d = 0.6 * 0.59,
                          e = 0.14;
  static double shown(double x) { return std::min((a * x * x + b * x) / (c * x * x + d * x + e), 1.0); }
  /// The radiance that is shown at y: the larger root of (a - c y) x^2 + (b - d y) x - e y = 0.
  static double inverse(double y) {
    const double p = a - c * y, q = b - d * y;
    return (-q + std::sqrt(q * q + 4 * p * e * y)) / (2 * p);
  }
};

Plane exposed(const Image& image, double stops) {
  Plane result;
  result.reserve(image.pixels.size());
  const double gain = std::exp2(stops);
  for (const float x : image.pixels) result.push_back(Aces::shown(std::max(double{x}, 0.0) * gain));
  return result;
}

double mean_of(const Plane& plane) {
  return std::accumulate(plane.begin(), plane.end(), 0.0) / static_cast<double>(plane.size());
}

}  // namespace

std::vector<double> flip_map(const std::vector<double>& test, const std::vector<double>& reference, int width,
                             int height) {
  const Seen a = see(test, width, height), b = see(reference, width, height);
  Plane errors(a.edges.size());
  for (size_t p = 0; p < errors.size(); ++p) {
    const double colour = redistributed(colour_difference(a.colours[p], b.colours[p]));
    const double feature = std::max(std::abs(a.edges[p] - b.edges[p]), std::abs(a.points[p] - b.points[p]));
    // Both are at most sqrt(2), but for rounding.
    const double exponent = 1 - std::pow(std::min(feature / std::sqrt(2.0), 1.0), kFeatureExponent);
    errors[p] = std::pow(colour, exponent);
  }
  return errors;
}

double flip(const Image& denoised, const Image& reference) {
  if (!comparable(denoised, reference)) return std::numeric_limits<double>::quiet_NaN();
  Plane d = display_values(denoised), r = display_values(reference);
  for (Plane* plane : {&d, &r})
    for (double& x : *plane) x = std::min(srgb_inverse(x), 1.0);
  return mean_of(flip_map(d, r, reference.width, reference.height));
}

FlipExposures flip_exposures(const Image& reference) {
  const size_t count = reference.plane_size();
  Plane luminance;
  for (size_t p = 0; p < count; ++p) {
    double y = 0;
    for (size_t c = 0; c < 3; ++c)
      y += primaries().to_xyz[1][c] * std::max(reference.pixels[c * count + p], 0.0F);
    luminance.push_back(std::max(y, kLeastLuminance));
  }
  std::sort(luminance.begin(), luminance.end());
  FlipExposures exposures;
  const double shown = Aces::inverse(kShownMost);
  exposures.start = std::log2(shown / luminance.back());
  exposures.stop = std::log2(shown / luminance[count / 2]);
  exposures.count = std::max(2, static_cast<int>(std::ceil(exposures.stop - exposures.start)));
  return exposures;
}

double hdr_flip(const Image& denoised, const Image& reference) {
  if (!comparable(denoised, reference)) return std::numeric_limits<double>::quiet_NaN();
  const FlipExposures exposures = flip_exposures(reference);
  Plane largest(reference.plane_size());
  for (int i = 0; i < exposures.count; ++i) {
    const double stops = exposures.start + (exposures.stop - exposures.start) * i / (exposures.count - 1);
    const Plane errors =
        flip_map(exposed(denoised, stops), exposed(reference, stops), reference.width, reference.height);
    for (size_t p = 0; p < errors.size(); ++p) largest[p] = std::max(largest[p], errors[p]);
  }
  return mean_of(largest);
}

std::string flip_formula() {
  return fmt::format(
      "mean over pixels of LDR-FLIP (Andersson et al. 2020) of T(d) and T(r), {:.2f} pixels a "
      "degree, q_c = {:g}, q_f = {:g}, p_c = {:g}, p_t = {:g}",
      kFlipPixelsPerDegree, kColourExponent, kFeatureExponent, kColourShare, kColourShown);
}

std::string hdr_flip_formula() {
  return fmt::format(
      "mean over pixels of HDR-FLIP (Andersson et al. 2021): the largest LDR-FLIP over exposures of r, from "
      "its brightest to its median luminance shown at {:g}, ACES tone map, {:.2f} pixels a degree",
      kShownMost, kFlipPixelsPerDegree);
}

}  // namespace ld
