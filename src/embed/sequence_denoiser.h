// What a program that embeds us denoises with: weights or a filter, and what they remember of the frames
// before.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "filters/frame_filter.h"
#include "inference/denoiser.h"

namespace ld {

/// Every frame is the next of a sequence, until restart() or another size. Not for several threads at once.
class SequenceDenoiser {
 public:
  /// Weights, as Denoiser takes them.
  explicit SequenceDenoiser(const std::string& weights);
  /// A filter, as FrameFilter takes it.
  explicit SequenceDenoiser(const FilterArgument& filter);

  /// "layer", "svgf"
  const std::string& name() const;
  /// What it reads of each sample, and what of it must be there.
  const std::vector<std::string>& features() const { return features_; }
  const std::vector<std::string>& required() const { return required_; }
  /// Whether frames have something of those before.
  bool remembers() const;

  /// OpenEXR's worldToCamera and worldToNDC of the following frames, for filters.
  void set_camera(const std::optional<Matrix4>& world_to_camera, const std::optional<Matrix4>& world_to_ndc);

  /// The next frame follows none of those before.
  void restart() { state_.end(); }

  /// The picture and what was filtered with its weights. A frame that is not finished leaves nothing to the
  /// next one. Throws what Denoiser::denoise_parts() does, and UsageError for parts of the light, alpha
  /// or a memory budget where a filter is to denoise.
  DenoisedParts denoise(const SampleArrays& arrays, const DenoiseOptions& options);

  /// What was left out of the last frame's work (DenoiseOptions::skip_within); nothing by filters.
  Skipped skipped() const { return model_ ? model_->skipped() : Skipped(); }

 private:
  std::optional<Denoiser> model_;  // or:
  std::optional<FrameFilter> filter_;
  std::vector<std::string> features_, required_;
  std::optional<Matrix4> world_to_camera_, world_to_ndc_;
  SequenceState state_;
  int64_t position_ = 0;  // of the next frame in its sequence
};

}  // namespace ld
