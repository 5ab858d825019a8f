#include "metrics/ssim.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "metrics/image_pair.h"

namespace ld {
namespace {

/// The window's weights along one axis: odd in number, summing to 1.
std::vector<double> window_weights(int width, int height) {
  const int largest = std::min({width, height, kSsimWindow});
  const int radius = (largest - 1) / 2;
  std::vector<double> weights;
  for (int i = -radius; i <= radius; ++i)
    weights.push_back(std::exp(-0.5 * i * i / (kSsimSigma * kSsimSigma)));
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// Window means wherever the window lies inside the plane: rows first, then columns; [h - n + 1, w - n + 1].
std::vector<double> window_means(const std::vector<double>& plane, int width, int height,
                                 const std::vector<double>& weights) {
  const int n = static_cast<int>(weights.size());
  const int inner_width = width - n + 1, inner_height = height - n + 1;
  std::vector<double> rows(size_t(inner_width) * size_t(height));
  for (int y = 0; y < height; ++y) {
    const double* in = plane.data() + size_t(y) * size_t(width);
    double* out = rows.data() + size_t(y) * size_t(inner_width);
    for (int k = 0; k < n; ++k)
      for (int x = 0; x < inner_width; ++x) out[x] += weights[size_t(k)] * in[x + k];
  }
  std::vector<double> means(size_t(inner_width) * size_t(inner_height));
  for (int y = 0; y < inner_height; ++y) {
    double* out = means.data() + size_t(y) * size_t(inner_width);
    for (int k = 0; k < n; ++k) {
      const double* in = rows.data() + size_t(y + k) * size_t(inner_width);
      for (int x = 0; x < inner_width; ++x) out[x] += weights[size_t(k)] * in[x];
    }
  }
  return means;
}

std::vector<double> product(const std::vector<double>& a, const std::vector<double>& b) {
  std::vector<double> result(a.size());
  std::transform(a.begin(), a.end(), b.begin(), result.begin(), [](double x, double y) { return x * y; });
  return result;
}

double plane_ssim(const std::vector<double>& a, const std::vector<double>& b, int width, int height) {
  const std::vector<double> weights = window_weights(width, height);
  const auto means = [&](const std::vector<double>& plane) {
    return window_means(plane, width, height, weights);
  };
  const std::vector<double> mean_a = means(a), mean_b = means(b);
  const std::vector<double> mean_aa = means(product(a, a)), mean_bb = means(product(b, b));
  const std::vector<double> mean_ab = means(product(a, b));

  constexpr double c1 = kSsimK1 * kSsimK1, c2 = kSsimK2 * kSsimK2;
  double sum = 0;
  for (size_t i = 0; i < mean_a.size(); ++i) {
    const double ma = mean_a[i], mb = mean_b[i];
    // E[x^2] - E[x]^2 is safe here: values up to 1 in double err by 1e-16, beside c2 = 9e-4.
    const double variance_a = mean_aa[i] - ma * ma, variance_b = mean_bb[i] - mb * mb;
    const double covariance = mean_ab[i] - ma * mb;
    sum += (2 * ma * mb + c1) * (2 * covariance + c2) /
           ((ma * ma + mb * mb + c1) * (variance_a + variance_b + c2));
  }
  return sum / static_cast<double>(mean_a.size());
}

}  // namespace

double ssim(const Image& denoised, const Image& reference) {
  if (!comparable(denoised, reference)) return std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> d = display_values(denoised);
  const std::vector<double> r = display_values(reference);
  const auto plane_size = static_cast<std::ptrdiff_t>(reference.plane_size());
  double sum = 0;
  for (int c = 0; c < 3; ++c) {
    const std::vector<double> plane_d(d.begin() + c * plane_size, d.begin() + (c + 1) * plane_size);
    const std::vector<double> plane_r(r.begin() + c * plane_size, r.begin() + (c + 1) * plane_size);
    sum += plane_ssim(plane_d, plane_r, reference.width, reference.height);
  }
  return sum / 3;
}

std::string ssim_formula() {
  return fmt::format(
      "mean over channels and windows of (2 m_d m_r + C1) (2 s_dr + C2) / ((m_d^2 + m_r^2 + C1) (s_d^2 + "
      "s_r^2 "
      "+ C2)), m and s the window's weighted means and (co)variances of T(d) and T(r), C1 = {:g}^2, C2 = "
      "{:g}^2",
      kSsimK1, kSsimK2);
}

}  // namespace ld
