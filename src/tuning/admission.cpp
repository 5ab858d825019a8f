#include "tuning/admission.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "core/error.h"
#include "tuning/decisions.h"

namespace ld {
namespace {

bool within(const Requirement& requirement, double ms, double factor) {
  return !requirement.budget_ms || ms <= factor * *requirement.budget_ms;
}

[[noreturn]] void fail_budget(double budget_ms, const std::string& name, double ms, bool measured) {
  fail(
      "no candidate denoises a frame within {:g} ms: the cheapest, {}, {} {:.3g} ms; give a larger "
      "--budget-ms, a smaller --at, fewer --samples or more --threads",
      budget_ms, name, measured ? "took" : "should take", ms);
}

/// The point's time, in 8 bits where it is beyond the budget otherwise. false when a stop was asked for.
bool measure(Point& point, const Requirement& requirement, const SearchTools& tools) {
  const NetworkConfig& network = point.candidate.config.network;
  for (const bool eight_bits : {false, true}) {
    const std::optional<NetworkTime> time = tools.measure(point.name, network, eight_bits);
    if (!time) return false;
    if (eight_bits && time->ms >= point.time.ms) break;
    point.time = *time;
    point.eight_bits = eight_bits;
    if (within(requirement, time->ms, 1) || !within(requirement, time->ms, kBeyondDoubt)) break;
  }
  return true;
}

}  // namespace

std::optional<Admission> admit(const std::vector<Candidate>& space, const Requirement& requirement,
                               double minutes, const SearchTools& tools) {
  std::vector<double> predicted;
  for (const Candidate& candidate : space) predicted.push_back(tools.predict_ms(candidate.config.network));
  std::vector<size_t> order = in_order(space, predicted, requirement);
  const size_t all = order.size();
  order.erase(std::remove_if(order.begin(), order.end(),
                             [&](size_t i) { return !within(requirement, predicted[i], kBeyondDoubt); }),
              order.end());
  if (order.empty()) {
    const size_t cheapest = size_t(std::min_element(predicted.begin(), predicted.end()) - predicted.begin());
    fail_budget(*requirement.budget_ms, space[cheapest].name, predicted[cheapest], false);
  }
  const size_t groups = feature_groups(space[0].config.network.features).size();
  const size_t most = affordable_candidates(order.size(), groups, minutes);
  Admission admission;
  size_t too_slow = 0;
  std::pair<double, std::string> cheapest = {std::numeric_limits<double>::infinity(), ""};
  for (const size_t i : order) {
    if (admission.points.size() == most) break;
    Point point{space[i].name, "", space[i], {}, std::numeric_limits<double>::quiet_NaN(), {}, predicted[i]};
    if (!measure(point, requirement, tools)) return std::nullopt;
    cheapest = std::min(cheapest, {point.time.ms, point.name});
    if (within(requirement, point.time.ms, 1))
      admission.points.push_back(point);
    else
      ++too_slow;
  }
  const size_t count = admission.points.size(), no_time = order.size() - count - too_slow;
  if (count == 0) fail_budget(*requirement.budget_ms, cheapest.second, cheapest.first, true);
  admission.sentence = fmt::format("{} of {} candidates train", count, all);
  const auto in_eight_bits = std::count_if(admission.points.begin(), admission.points.end(),
                                           [](const Point& point) { return point.eight_bits; });
  if (in_eight_bits > 0)
    admission.sentence += fmt::format(", {} of them for the budget that 8 bits keep", in_eight_bits);
  if (requirement.budget_ms)
    admission.sentence +=
        fmt::format("; {} are beyond {:g} times the budget by their graphs, {} beyond it by the clock",
                    all - order.size(), kBeyondDoubt, too_slow);
  if (no_time > 0) admission.sentence += fmt::format("; for {} there is no time", no_time);
  admission.sentence += ".";
  admission.plan = plan_search(count, groups, minutes);
  return admission;
}

}  // namespace ld
