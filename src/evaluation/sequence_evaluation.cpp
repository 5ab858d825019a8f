#include "evaluation/sequence_evaluation.h"

#include <fmt/format.h>

#include <cmath>

#include "core/error.h"
#include "core/log.h"
#include "evaluation/evaluator.h"

namespace ld {
namespace {

struct CurveText {
  const char *name, *title, *x_label, *y_label;
};
constexpr CurveText kCurves[] = {
    {"sequence_error", "Error over the frames", "frame of the sequence", "mean |T(d) - T(r)|"},
    {"sequence_temporal", "Temporal error over the frames", "frame of the sequence", "TE"},
    {"sequence_change", "Error of the change from frame to frame", "frame of the sequence",
     "root mean square of e, not warped"},
    {"sequence_ghosting", "After pixels came into view or their light changed", "frames since then",
     "share of the change that is missing"},
};

/// The scores of a sequence as one: means over the frames, then the measures.
FrameScores whole(const std::vector<FrameScores>& frames, size_t metrics, const SequenceScores& measures) {
  FrameScores scores;
  scores.frame = fmt::format("{} + {}", frames.front().frame, frames.size() - 1);
  scores.applies.assign(metrics, true);
  double seconds = 0;
  bool timed = true;
  for (size_t m = 0; m < metrics; ++m) {
    double sum = 0;
    for (const FrameScores& frame : frames) sum += frame.values[m];
    scores.values.push_back(sum / static_cast<double>(frames.size()));
  }
  for (const FrameScores& frame : frames) {
    scores.not_finite += frame.not_finite;
    timed = timed && frame.seconds;
    seconds += frame.seconds.value_or(0);
  }
  if (timed) scores.seconds = seconds / static_cast<double>(frames.size());
  scores.values.insert(scores.values.end(), measures.values.begin(), measures.values.end());
  scores.applies.insert(scores.applies.end(), measures.applies.begin(), measures.applies.end());
  return scores;
}

}  // namespace

Evaluation sequence_scores(const Evaluation& evaluation) {
  Evaluation result = evaluation.sequences->evaluation;
  result.data = evaluation.data;
  result.split = evaluation.split;
  result.samples = evaluation.samples;
  result.baseline = evaluation.baseline;
  return result;
}

SequenceScorer::SequenceScorer(const std::vector<std::string>& names,
                               const std::vector<const Metric*>& metrics)
    : names_(names) {
  evaluation_.of_sequences = true;
  evaluation_.metrics = metrics;
  for (const Metric& measure : sequence_measures()) evaluation_.metrics.push_back(&measure);
  for (const std::string& name : names) evaluation_.methods.push_back({name, {}, {}});
  for (const CurveText& curve : kCurves) curves_[curve.name].resize(names.size());
}

void SequenceScorer::add(const EvaluationFrame& frame, const std::vector<const Image*>& pictures,
                         const std::vector<const FrameScores*>& scores) {
  const bool follows = frame.in_sequence && ground_.frames > 0 &&
                       frame.in_sequence->sequence == place_.sequence &&
                       frame.in_sequence->position == place_.position + 1 &&
                       ground_.width == frame.reference.width && ground_.height == frame.reference.height;
  if (!follows) end_sequence();
  if (!frame.in_sequence) return;
  place_ = *frame.in_sequence;
  if (meters_.empty()) {
    meters_.resize(names_.size());
    frames_.resize(names_.size());
  }
  const SurfaceGuides guides = surface_guides(frame.frame);
  flow_missing_ = flow_missing_ || !guides.has_flow;
  ground_.advance(guides, frame.reference);
  for (size_t m = 0; m < names_.size(); ++m) {
    meters_[m].add(ground_, *pictures[m]);
    frames_[m].push_back(*scores[m]);
  }
}

void SequenceScorer::end_sequence() {
  const auto count = [](Curve& curve, const std::vector<double>& values) {
    if (curve.size() < values.size()) curve.resize(values.size());
    for (size_t i = 0; i < values.size(); ++i) {
      if (std::isnan(values[i])) continue;
      curve[i].sum += values[i];
      ++curve[i].count;
    }
  };
  for (size_t m = 0; ground_.frames > 1 && m < names_.size(); ++m) {
    const size_t metrics = evaluation_.metrics.size() - sequence_measures().size();
    evaluation_.methods[m].frames.push_back(
        whole(frames_[m], metrics, meters_[m].scores(ground_, meters_[0])));
    std::vector<double> error, temporal, change;
    for (const SequenceFrame& frame : meters_[m].frames()) {
      error.push_back(frame.error);
      temporal.push_back(frame.warped);
      change.push_back(frame.unwarped);
    }
    const auto ages = meters_[m].left_by_age();
    count(curves_["sequence_error"][m], error);
    count(curves_["sequence_temporal"][m], temporal);
    count(curves_["sequence_change"][m], change);
    count(curves_["sequence_ghosting"][m], {ages.begin(), ages.end()});
  }
  ground_ = {};
  meters_.clear();
  frames_.clear();
}

SequenceResults SequenceScorer::finish() {
  end_sequence();
  if (evaluation_.methods.front().frames.empty())
    fail(
        "no two frames of this split follow one another; expected sequences, whose frames have `sequence` "
        "and "
        "`position` in manifest.json (docs/rendering.md)");
  if (flow_missing_)
    spdlog::warn(
        "frames without the feature flow: nothing tells where pixels were before, so warped errors, flicker "
        "and ghosting are not measured there");
  SequenceResults results{std::move(evaluation_), {}};
  for (const CurveText& text : kCurves) {
    LinePlot plot;
    plot.title = text.title;
    plot.x_label = text.x_label;
    plot.y_label = text.y_label;
    for (size_t m = 0; m < names_.size(); ++m) {
      PlotLine line{names_[m], {}};
      const Curve& curve = curves_[text.name][m];
      for (size_t i = 0; i < curve.size(); ++i)
        if (curve[i].count > 0) line.points.emplace_back(double(i), curve[i].sum / curve[i].count);
      if (!line.points.empty()) plot.lines.push_back(std::move(line));
    }
    if (!plot.lines.empty()) results.curves.push_back({text.name, std::move(plot)});
  }
  return results;
}

}  // namespace ld
