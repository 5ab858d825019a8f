// Which points of a search are kept, and which is chosen.
#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <tuple>
#include <utility>

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

constexpr size_t kFinalistsAtMost = 6;

}  // namespace

std::vector<size_t> in_order(const std::vector<Candidate>& space, const std::vector<double>& predicted,
                             const Requirement& requirement) {
  std::vector<size_t> order(space.size());
  for (size_t i = 0; i < order.size(); ++i) order[i] = i;
  if (!requirement.budget_ms) return order;
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return predicted[a] > predicted[b]; });
  std::map<std::string, size_t> seen;  // of each network
  std::vector<size_t> round(space.size());
  for (const size_t i : order) round[i] = seen[space[i].network]++;
  std::stable_sort(order.begin(), order.end(),
                   [&](size_t a, size_t b) { return std::pair(round[a], a) < std::pair(round[b], b); });
  return order;
}

void mark_unbeaten(std::vector<Point>& points) {
  for (Point& point : points)
    point.unbeaten =
        std::none_of(points.begin(), points.end(), [&](const Point& other) { return beats(other, point); });
}

std::vector<size_t> finalists_of(const std::vector<Point>& points, const Requirement& requirement) {
  std::vector<size_t> places;
  for (size_t i = 0; i < points.size(); ++i)
    if (points[i].unbeaten) places.push_back(i);
  const auto rank = [&](size_t i) {
    const Point& point = points[i];
    const bool hopeless = requirement.budget_ms && point.time.ms > kBeyondDoubt * *requirement.budget_ms,
               reaches = requirement.target_smape && point.error <= *requirement.target_smape;
    return std::tuple(hopeless, !reaches, reaches ? point.time.ms : point.error);
  };
  std::sort(places.begin(), places.end(), [&](size_t a, size_t b) { return rank(a) < rank(b); });
  places.resize(std::min(places.size(), kFinalistsAtMost));
  return places;
}

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
