#include "tuning/halving.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace ld {
namespace {

/// Of the time, what finds out which features pay, and what trains the network that was found. What is left
/// finds the network.
constexpr double kFeatureShare = 0.2, kFinalShare = 0.25;
constexpr double kLeastMinutes = 0.5;  // of a first rung from which anything can be told
constexpr size_t kFinalists = 2;

}  // namespace

double SearchPlan::minutes() const {
  double sum = double(feature_trials) * feature_minutes + final_minutes;
  for (const Rung& rung : rungs) sum += double(rung.candidates) * rung.minutes;
  return sum;
}

SearchPlan plan_search(size_t candidates, size_t feature_groups, double minutes) {
  SearchPlan plan;
  double units = 0, unit = 1;  // of the first rung's minutes
  for (size_t left = candidates;; left = (left + 1) / 2, unit *= 2) {
    plan.rungs.push_back({left, unit});
    units += double(left) * unit;
    if (left <= kFinalists) break;
  }
  const double for_features = feature_groups > 0 ? kFeatureShare : 0;
  for (Rung& rung : plan.rungs) rung.minutes *= (1 - for_features - kFinalShare) * minutes / units;
  plan.feature_trials = feature_groups > 0 ? feature_groups + 1 : 0;
  if (feature_groups > 0) plan.feature_minutes = for_features * minutes / double(plan.feature_trials);
  plan.final_minutes = kFinalShare * minutes;
  return plan;
}

size_t affordable_candidates(size_t all, size_t feature_groups, double minutes) {
  size_t most = all;
  while (most > kFinalists && plan_search(most, feature_groups, minutes).rungs[0].minutes < kLeastMinutes)
    --most;
  return most;
}

std::string plan_text(const SearchPlan& plan) {
  std::vector<std::string> parts;
  for (const Rung& rung : plan.rungs)
    parts.push_back(fmt::format("{} for {:.2g} min each", rung.candidates, rung.minutes));
  std::string text =
      fmt::format("{:.3g} minutes of training: networks {}", plan.minutes(), fmt::join(parts, ", then "));
  if (plan.feature_trials > 0)
    text += fmt::format("; features {} for {:.2g} min each", plan.feature_trials, plan.feature_minutes);
  return text + fmt::format("; what was found for {:.2g} min", plan.final_minutes);
}

}  // namespace ld
