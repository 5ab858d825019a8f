#include "evaluation/comparison.h"

#include <limits>
#include <numeric>

#include "core/error.h"
#include "metrics/metric.h"

namespace ld {
namespace {

PairedMetric compare(const Metric& metric, const std::vector<double>& method,
                     const std::vector<double>& baseline) {
  PairedMetric result;
  if (method.empty()) {
    result.mean_difference = std::numeric_limits<double>::quiet_NaN();
    return result;
  }
  std::vector<double> differences;
  for (size_t f = 0; f < method.size(); ++f) {
    differences.push_back(method[f] - baseline[f]);
    if (better(metric, method[f], baseline[f]))
      ++result.better;
    else if (better(metric, baseline[f], method[f]))
      ++result.worse;
    else
      ++result.equal;
  }
  result.mean_difference =
      std::accumulate(differences.begin(), differences.end(), 0.0) / static_cast<double>(differences.size());
  result.interval = mean_interval(differences);
  result.p = signed_rank_p(differences);
  return result;
}

}  // namespace

Comparison compare_with(const Evaluation& evaluation, const MethodScores& baseline) {
  Comparison comparison{baseline.name, baseline.frames.size(), {}};
  for (const MethodScores& method : evaluation.methods) {
    if (method.name == baseline.name) continue;
    if (method.frames.size() != baseline.frames.size())
      fail("{} has {} frames, {} has {}; a comparison needs the same ones", method.name, method.frames.size(),
           baseline.name, baseline.frames.size());
    PairedMethod paired{method.name, {}};
    for (size_t m = 0; m < evaluation.metrics.size(); ++m)
      paired.metrics.push_back(compare(*evaluation.metrics[m], method.values(m), baseline.values(m)));
    comparison.methods.push_back(std::move(paired));
  }
  return comparison;
}

}  // namespace ld
