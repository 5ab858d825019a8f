#include "evaluation/scores.h"

#include <limits>
#include <numeric>

#include "core/error.h"

namespace ld {

double MethodScores::mean(size_t metric) const {
  const std::vector<double> known = values(metric);
  if (known.empty()) return std::numeric_limits<double>::quiet_NaN();
  return std::accumulate(known.begin(), known.end(), 0.0) / static_cast<double>(known.size());
}

std::vector<double> MethodScores::values(size_t metric) const {
  std::vector<double> result;
  for (const FrameScores& frame : frames)
    if (frame.has(metric)) result.push_back(frame.values.at(metric));
  return result;
}

std::optional<double> MethodScores::mean_seconds() const {
  if (frames.empty()) return std::nullopt;
  double sum = 0;
  for (const FrameScores& frame : frames) {
    if (!frame.seconds) return std::nullopt;
    sum += *frame.seconds;
  }
  return sum / static_cast<double>(frames.size());
}

int64_t MethodScores::not_finite() const {
  int64_t sum = 0;
  for (const FrameScores& frame : frames) sum += frame.not_finite;
  return sum;
}

const MethodScores& Evaluation::method(const std::string& name) const {
  for (const MethodScores& method : methods)
    if (method.name == name) return method;
  fail("the evaluation holds no method '{}'", name);
}

const MethodScores& Evaluation::baseline_method() const {
  if (methods.empty()) fail("the evaluation holds no method");
  if (baseline.empty()) return methods.size() > 2 ? methods[2] : methods.front();
  std::vector<std::string> names;
  for (const MethodScores& method : methods) {
    if (method.name == baseline) return method;
    names.push_back(method.name);
  }
  fail_usage("no method '{}' to compare with; there are {}", baseline, fmt::join(names, ", "));
}

}  // namespace ld
