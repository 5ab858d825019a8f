#include "tuning/gain.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <numeric>

#include "core/error.h"
#include "metrics/statistics.h"

namespace ld {

double mean_error(const std::vector<double>& errors) {
  if (errors.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::accumulate(errors.begin(), errors.end(), 0.0) / double(errors.size());
}

Gain gain_of(const std::vector<double>& dearer, const std::vector<double>& cheaper) {
  constexpr double kOfOneFrame = 0.05;
  if (dearer.size() != cheaper.size() || dearer.empty())
    fail("{} and {} errors; a comparison needs those of the same frames", dearer.size(), cheaper.size());
  std::vector<double> differences;
  for (size_t f = 0; f < dearer.size(); ++f) differences.push_back(cheaper[f] - dearer[f]);
  Gain gain;
  const double before = mean_error(cheaper);
  gain.relative = before > 0 ? mean_error(differences) / before : 0;
  if (differences.size() >= size_t(kFewestFrames)) {
    gain.p = signed_rank_p(differences);
    gain.sure = gain.p && *gain.p < 1 - kConfidence;
  } else if (const auto interval = mean_interval(differences)) {
    gain.sure = interval->low > 0 || interval->high < 0;
  } else {
    gain.sure = std::fabs(gain.relative) >= kOfOneFrame;
  }
  return gain;
}

std::string gain_text(const Gain& gain) {
  if (gain.relative == 0) return "gains nothing";
  const std::string amount =
      fmt::format("{} {:.2g} %", gain.relative < 0 ? "loses" : "gains", 100 * std::fabs(gain.relative));
  if (gain.p) return amount + fmt::format(" (p = {:.2g})", *gain.p);
  return amount + (gain.sure ? "" : " (not sure: too few frames)");
}

}  // namespace ld
