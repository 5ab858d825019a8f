#include "render/geometry/robust_mean.h"

#include <algorithm>
#include <cmath>

namespace ld {
namespace {

double channel_sum(const Radiance& value) {
  return value[0] + value[1] + value[2];
}

Radiance mean_of(const std::vector<Radiance>& estimates, size_t begin, size_t end) {
  Radiance sum = {0, 0, 0};
  for (size_t i = begin; i < end; ++i)
    for (size_t c = 0; c < 3; ++c) sum[c] += estimates[i][c];
  for (double& channel : sum) channel /= static_cast<double>(end - begin);
  return sum;
}

}  // namespace

Radiance plain_mean(const std::vector<Radiance>& estimates) {
  return mean_of(estimates, 0, estimates.size());
}

double gini_coefficient(const std::vector<double>& ascending) {
  // Half the mean absolute difference over the mean, for ordered numbers a sum over their ranks.
  const auto n = static_cast<double>(ascending.size());
  double sum = 0, ranked = 0;
  for (size_t i = 0; i < ascending.size(); ++i) {
    sum += ascending[i];
    ranked += (2.0 * static_cast<double>(i) + 1 - n) * ascending[i];
  }
  return sum > 0 ? std::max(0.0, ranked / (n * sum)) : 0;
}

Radiance robust_mean(std::vector<Radiance> estimates) {
  const Radiance mean = plain_mean(estimates);
  if (!std::isfinite(channel_sum(mean))) return mean;
  std::stable_sort(estimates.begin(), estimates.end(),
                   [](const Radiance& a, const Radiance& b) { return channel_sum(a) < channel_sum(b); });
  std::vector<double> sums(estimates.size());
  std::transform(estimates.begin(), estimates.end(), sums.begin(), channel_sum);
  const auto n = estimates.size();
  const auto left_out = static_cast<size_t>(gini_coefficient(sums) * static_cast<double>(n) / 2);
  // At most (n - 1) / 2 at either end, because the coefficient is at most 1 - 1 / n; rounding must not add
  // one.
  const size_t dropped = std::min(left_out, (n - 1) / 2);
  return dropped == 0 ? mean : mean_of(estimates, dropped, n - dropped);
}

}  // namespace ld
