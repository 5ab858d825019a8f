#include "metrics/detail_filter.h"

#include <cmath>
#include <cstddef>
#include <numeric>

namespace ld {

const std::array<double, kDetailTaps>& detail_kernel() {
  static const std::array<double, kDetailWindow* kDetailWindow> kernel = [] {
    constexpr int radius = kDetailWindow / 2;
    constexpr double variance = kDetailSigma * kDetailSigma;
    const auto squared_radius = [](size_t i) {
      const int x = static_cast<int>(i) % kDetailWindow - radius,
                y = static_cast<int>(i) / kDetailWindow - radius;
      return static_cast<double>(x * x + y * y);
    };
    std::array<double, kDetailTaps> weights{};
    for (size_t i = 0; i < weights.size(); ++i) weights[i] = std::exp(-squared_radius(i) / (2 * variance));
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    for (size_t i = 0; i < weights.size(); ++i)
      weights[i] *= (squared_radius(i) - 2 * variance) / (variance * variance * sum);
    const double mean = std::accumulate(weights.begin(), weights.end(), 0.0) / double(weights.size());
    for (double& weight : weights) weight -= mean;
    return weights;
  }();
  return kernel;
}

std::vector<double> fine_detail(const std::vector<double>& plane, int width, int height) {
  const int inner_width = width - kDetailWindow + 1, inner_height = height - kDetailWindow + 1;
  if (inner_width < 1 || inner_height < 1) return {};
  std::vector<double> result(size_t(inner_width) * size_t(inner_height));
  for (int y = 0; y < inner_height; ++y) {
    double* const out = result.data() + size_t(y) * size_t(inner_width);
    for (int k = 0; k < kDetailWindow * kDetailWindow; ++k) {
      const double* const in =
          plane.data() + size_t(y + k / kDetailWindow) * size_t(width) + k % kDetailWindow;
      const double weight = detail_kernel()[size_t(k)];
      for (int x = 0; x < inner_width; ++x) out[x] += weight * in[x];
    }
  }
  return result;
}

}  // namespace ld
