#include "training/optimizer/stage_scheme.h"

#include "core/error.h"
#include "training/optimizer/clip_pass.h"

namespace ld {

using torch::Tensor;

bool needs_noisy(const OptimizerConfig& config) {
  return config.scheme == "separate" || config.scheme == "concurrent" ||
         (config.scheme == "two_heads" && config.head_weight > 0);
}

Tensor batch_loss(Network& network, Batch& batch, const ClipLoss& loss, const OptimizerConfig& config) {
  if (!needs_noisy(config)) {
    const int64_t clip = batch.clip;
    const Compared compared = compare_clips(network, std::move(batch), config.truncation);
    return loss(compared.predicted, compared.target, clip);
  }
  if (!batch.noisy.defined())
    fail("optimizer.scheme '{}' needs a noisy picture beside each crop, and the batch has none",
         config.scheme);
  const SecondReads reads = config.scheme == "separate"     ? SecondReads::given
                            : config.scheme == "concurrent" ? SecondReads::first_stopped
                                                            : SecondReads::first;
  const Stages made = network.stages(std::move(batch.input), reads, batch.noisy);
  const double weight = config.scheme == "two_heads" ? config.head_weight : 1;
  return loss(made.picture, batch.reference, batch.clip) + weight * loss(made.first, batch.noisy, batch.clip);
}

}  // namespace ld
