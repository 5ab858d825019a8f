#include "metrics/statistics.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>

#include "core/pi.h"

namespace ld {
namespace {

constexpr size_t kExactDifferences = 50;

bool all_finite(const std::vector<double>& values) {
  return std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); });
}

/// P(|T| <= t) by the finite sums for whole degrees of freedom (Abramowitz and Stegun, 26.7.3 and 26.7.4).
double student_t_within(double t, int degrees) {
  const double theta = std::atan2(t, std::sqrt(static_cast<double>(degrees)));
  const double cosine = std::cos(theta), sine = std::sin(theta);
  const bool odd = degrees % 2 == 1;
  double term = odd ? cosine : 1, sum = degrees == 1 ? 0 : term;
  for (int k = odd ? 3 : 2; k <= degrees - 2; k += 2) {
    term *= cosine * cosine * (k - 1) / k;
    sum += term;
  }
  return odd ? 2 / kPi * (theta + sine * sum) : sine * sum;
}

/// Twice the ranks of the magnitudes (whole numbers even where equal magnitudes share a mean), in the order
/// of the magnitudes, and the sum of t^3 - t over the groups of t equal ones.
struct Ranks {
  std::vector<size_t> doubled;
  double ties = 0;
};

Ranks doubled_ranks(const std::vector<double>& differences) {
  Ranks ranks;
  for (size_t first = 0; first < differences.size();) {
    size_t last = first;
    while (last + 1 < differences.size() && std::abs(differences[last + 1]) <= std::abs(differences[first]))
      ++last;
    const auto group = static_cast<double>(last - first + 1);
    ranks.ties += group * group * group - group;
    for (size_t i = first; i <= last; ++i) ranks.doubled.push_back(first + last + 2);
    first = last + 1;
  }
  return ranks;
}

/// P(a sum of randomly chosen ranks <= `limit`): counts the choices of each sum, one rank after the other.
double exact_lower_tail(const std::vector<size_t>& ranks, size_t limit) {
  const size_t total = std::accumulate(ranks.begin(), ranks.end(), size_t{0});
  std::vector<double> probability(total + 1, 0.0);
  probability[0] = 1;
  size_t reached = 0;
  for (const size_t rank : ranks) {
    reached += rank;
    for (size_t sum = reached + 1; sum-- > 0;)
      probability[sum] = 0.5 * (probability[sum] + (sum >= rank ? probability[sum - rank] : 0.0));
  }
  return std::accumulate(probability.begin(), probability.begin() + static_cast<std::ptrdiff_t>(limit) + 1,
                         0.0);
}

}  // namespace

double student_t_limit(int degrees) {
  double low = 0, high = 13;  // of one degree: 12.706
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (student_t_within(middle, degrees) < kConfidence ? low : high) = middle;
  }
  return high;
}

std::optional<Interval> mean_interval(const std::vector<double>& values) {
  if (values.size() < 2 || !all_finite(values)) return std::nullopt;
  const auto n = static_cast<double>(values.size());
  const double mean = std::accumulate(values.begin(), values.end(), 0.0) / n;
  double squares = 0;
  for (const double x : values) squares += (x - mean) * (x - mean);
  const double reach =
      student_t_limit(static_cast<int>(values.size()) - 1) * std::sqrt(squares / (n - 1) / n);
  return Interval{mean - reach, mean + reach};
}

std::optional<double> signed_rank_p(const std::vector<double>& differences) {
  if (!all_finite(differences)) return std::nullopt;
  std::vector<double> sorted;
  for (const double x : differences)
    if (x != 0) sorted.push_back(x);
  if (sorted.empty()) return std::nullopt;
  std::sort(sorted.begin(), sorted.end(), [](double a, double b) { return std::abs(a) < std::abs(b); });

  const Ranks ranks = doubled_ranks(sorted);
  size_t positive = 0, total = 0;
  for (size_t i = 0; i < sorted.size(); ++i) {
    total += ranks.doubled[i];
    if (sorted[i] > 0) positive += ranks.doubled[i];
  }
  const size_t smaller = std::min(positive, total - positive);
  if (sorted.size() <= kExactDifferences) return std::min(1.0, 2 * exact_lower_tail(ranks.doubled, smaller));

  const auto n = static_cast<double>(sorted.size());
  const double mean = n * (n + 1) / 4, variance = n * (n + 1) * (2 * n + 1) / 24 - ranks.ties / 48;
  const double z = (mean - 0.5 * static_cast<double>(smaller)) / std::sqrt(variance);
  return std::erfc(z / std::sqrt(2.0));
}

}  // namespace ld
