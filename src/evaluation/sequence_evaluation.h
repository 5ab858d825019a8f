// How steady methods are over the sequences of a data set: scores of whole sequences and curves over frames.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "evaluation/scores.h"
#include "metrics/sequence_meter.h"
#include "plot/svg_plot.h"
#include "sequence/sequence_state.h"

namespace ld {

struct EvaluationFrame;

/// A figure of one line a method, means over the sequences.
struct SequenceCurve {
  std::string name;  // of its file
  LinePlot plot;
};

/// Scores of whole sequences: of each metric of pictures the mean over its frames, then
/// sequence_measures(). Intervals and pairs of `evaluation` are over sequences.
struct SequenceResults {
  Evaluation evaluation;
  std::vector<SequenceCurve> curves;
};

/// The sequences' scores with what is said of all: data set, split, baseline. The evaluation must have them.
Evaluation sequence_scores(const Evaluation& evaluation);

/// Fed frame by frame while the pictures are made; frames that stand alone do not count.
class SequenceScorer {
 public:
  /// `names`: of the methods, noisy first; `metrics`: of the pictures.
  SequenceScorer(const std::vector<std::string>& names, const std::vector<const Metric*>& metrics);

  /// The next frame, each method's picture and its scores in the order of the names.
  void add(const EvaluationFrame& frame, const std::vector<const Image*>& pictures,
           const std::vector<const FrameScores*>& scores);
  /// After the last frame. Throws Error when there was no sequence of two frames or more.
  SequenceResults finish();

 private:
  void end_sequence();

  /// Sums over sequences of one method's values at one place of a curve.
  struct Mean {
    double sum = 0;
    int count = 0;
  };
  using Curve = std::vector<Mean>;

  std::vector<std::string> names_;
  Evaluation evaluation_;
  std::map<std::string, std::vector<Curve>> curves_;  // by their names, one for each method
  // Of the sequence that is being measured.
  SequenceGround ground_;
  std::vector<SequenceMeter> meters_;
  std::vector<std::vector<FrameScores>> frames_;  // for each method
  SequencePlace place_;
  bool flow_missing_ = false;
};

}  // namespace ld
