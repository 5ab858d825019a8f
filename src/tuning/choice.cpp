// Which points of a search are kept, and which is chosen.
#include <algorithm>
#include <cmath>
#include <tuple>

#include "tuning/decisions.h"
#include "tuning/gain.h"
#include "tuning/search.h"

namespace ld {
namespace {

bool meets(const Point& point, const Requirement& requirement) {
  if (!std::isfinite(point.error)) return false;
  return requirement.budget_ms ? point.time.ms <= *requirement.budget_ms
                               : point.error <= *requirement.target_smape;
}

}  // namespace

std::optional<size_t> choose(const std::vector<Point>& points, const Requirement& requirement) {
  std::vector<size_t> allowed;
  for (size_t i = 0; i < points.size(); ++i)
    if (meets(points[i], requirement)) allowed.push_back(i);
  if (allowed.empty()) return std::nullopt;
  const auto by_error = [&](size_t a, size_t b) {
    return std::tie(points[a].error, points[a].time.ms) < std::tie(points[b].error, points[b].time.ms);
  };
  const auto by_time = [&](size_t a, size_t b) {
    return std::tie(points[a].time.ms, points[a].error) < std::tie(points[b].time.ms, points[b].error);
  };
  if (requirement.target_smape) return *std::min_element(allowed.begin(), allowed.end(), by_time);
  const size_t best = *std::min_element(allowed.begin(), allowed.end(), by_error);
  std::vector<size_t> as_good;
  std::copy_if(allowed.begin(), allowed.end(), std::back_inserter(as_good), [&](size_t i) {
    return i == best || (points[i].time.ms < points[best].time.ms &&
                         !gain_of(points[best].errors, points[i].errors).pays());
  });
  size_t chosen = *std::min_element(as_good.begin(), as_good.end(), by_time);
  std::sort(allowed.begin(), allowed.end(), by_error);
  const auto better = std::find_if(allowed.begin(), allowed.end(),
                                   [&](size_t i) { return beats(points[i], points[chosen]); });
  if (better != allowed.end()) chosen = *better;  // the lowest error of all that beat it: nothing beats that
  return chosen;
}

std::vector<size_t> better_half(const std::vector<Point>& points, const Requirement& requirement) {
  std::vector<size_t> places;
  for (size_t i = 0; i < points.size(); ++i)
    if (std::isfinite(points[i].error)) places.push_back(i);
  std::stable_sort(places.begin(), places.end(), [&](size_t a, size_t b) {
    if (requirement.target_smape) {
      const bool a_meets = meets(points[a], requirement), b_meets = meets(points[b], requirement);
      if (a_meets != b_meets) return a_meets;
      if (a_meets) return points[a].time.ms < points[b].time.ms;
    }
    return points[a].error < points[b].error;
  });
  places.resize(std::min(places.size(), (points.size() + 1) / 2));
  return places;
}

}  // namespace ld
