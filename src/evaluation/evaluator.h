// Scores the noisy mean, the best blur and any number of methods on a set of frames.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "evaluation/method.h"
#include "evaluation/scores.h"
#include "frame/frame.h"
#include "sequence/sequence_state.h"

namespace ld {

struct EvaluationFrame {
  std::string name;
  Frame frame;                                    // sanitised
  Image reference;                                // [3, H, W], linear, of the frame's size
  ReferenceFloor floor = {};                      // of the reference
  PicturePlace place = {};                        // of the samples, where they come from a file
  std::optional<SequencePlace> in_sequence = {};  // none: a still
};

/// Frames that are loaded when they are needed, each twice: once to choose the blur, once to score. Those of
/// a sequence in its order, one sequence after the other.
struct FrameSet {
  size_t count = 0;
  std::function<EvaluationFrame(size_t)> load;
  std::vector<std::string> names = {};              // of the frames, where they are known beforehand
  std::vector<std::vector<size_t>> sequences = {};  // the frames of each one of two or more
};

struct LabelledPicture {
  std::string label;
  Image image;  // [3, H, W], linear
};

struct EvaluatorOptions {
  int threads = 1;
  std::vector<const Metric*> metrics = metrics_with({});  // metrics(), then further ones
  bool sequences = false;                                 // also how steady they are: Evaluation::sequences
  /// Called once a frame, in order: noisy, blur (the width that PSNR chose), each method, reference. May be
  /// empty.
  std::function<void(size_t frame, const std::string& name, const std::vector<LabelledPicture>&)> on_pictures;
};

/// Methods `noisy` and `blur`, then `methods` in their order. Of the blur, further metrics judge the width
/// that PSNR chose, and so do measures of sequences; the floor where all frames have one; Evaluation::data
/// and split stay empty. Each method has one state, which starts anew where a frame does not follow the one
/// before. A picture with NaN or infinite values scores NaN and is warned about. A stop signal ends it after
/// the current frame: nothing is returned, because half a set's mean would mislead. Throws UsageError for bad
/// method names; Error for an empty set, one without sequences where they are asked for, a reference or a
/// denoised picture of another size, with the names of frame and method.
std::optional<Evaluation> evaluate(const FrameSet& frames, const std::vector<Method>& methods,
                                   const EvaluatorOptions& options);

}  // namespace ld
