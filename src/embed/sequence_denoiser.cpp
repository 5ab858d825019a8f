#include "embed/sequence_denoiser.h"

#include <algorithm>

#include "core/threads.h"
#include "embed/frame_buffers.h"
#include "models/network_config.h"

namespace ld {

SequenceDenoiser::SequenceDenoiser(const std::string& weights) : model_(std::in_place, weights) {
  features_ = model_->network_config().features;
  required_ = model_->features();
  // Also where it is no feature of its own: the light is what is denoised.
  for (std::vector<std::string>* names : {&features_, &required_})
    if (std::find(names->begin(), names->end(), "radiance") == names->end())
      names->insert(names->begin(), "radiance");
}

SequenceDenoiser::SequenceDenoiser(const FilterArgument& filter) : filter_(filter) {
  features_ = filter_features();
  features_.insert(features_.begin(), "radiance");
  required_ = {"radiance"};
}

const std::string& SequenceDenoiser::name() const {
  return model_ ? model_->network_config().name : filter_->kind();
}

bool SequenceDenoiser::remembers() const {
  return model_ ? model_->remembers() : filter_->is_temporal();
}

void SequenceDenoiser::set_camera(const std::optional<Matrix4>& world_to_camera,
                                  const std::optional<Matrix4>& world_to_ndc) {
  world_to_camera_ = world_to_camera;
  world_to_ndc_ = world_to_ndc;
}

DenoisedParts SequenceDenoiser::denoise(const SampleArrays& arrays, const DenoiseOptions& options) {
  if (filter_ && (!arrays.parts.empty() || arrays.alpha))
    fail_usage("parts of the light and alpha go with models; a filter makes none");
  if (filter_ && options.max_memory_bytes > 0)
    fail_usage("a memory budget goes with models; a filter takes what its planes take");
  state_.advance(SequencePlace{0, position_}, arrays.width, arrays.height);
  ++position_;
  if (model_) return model_->denoise_parts(arrays, options, &state_);
  const int threads = options.threads > 0 ? options.threads : default_threads();
  Frame frame = gather(arrays, threads);
  frame.info.world_to_camera = world_to_camera_;
  frame.info.world_to_ndc = world_to_ndc_;
  return {filter_->denoise(frame, state_, threads), {}, {}};
}

}  // namespace ld
