// What a Trainer does when the training has collapsed: back to the best checkpoint, at half the learning
// rate.
#include <utility>

#include "core/log.h"
#include "training/fine_tuning.h"
#include "training/trainer.h"
#include "training/training_data.h"

namespace ld {

namespace {

/// Kernels of random weights deviate by 0.005 (Xavier) to 0.1 (He), those of saturated logits by 1e-7.
constexpr double kLeastDeviation = 1e-4;

}  // namespace

void Trainer::watch_step(double loss) {
  if (!config_.watch.enabled || !watch_loss(state_.watch, config_.watch, loss, state_.step)) return;
  collapse_ = fmt::format(
      "for {} steps the median of the loss was above {:g} times the usual {:.4g}; it is now {:.4g}",
      config_.watch.window * state_.watch.raised, config_.watch.loss_factor, usual_loss(state_.watch), loss);
}

/// Collective. Adds what the kernels look like to the row of a validation: those of the network that was
/// validated, for the first batch of the run each time, made beside the batches that are prepared for
/// training.
void Trainer::look_at_kernels(std::map<std::string, double>& row) {
  const torch::NoGradGuard no_graph;
  const KernelStatistics own = kernel_probe_(
      optimizer_.average().network(), training_set_.batch_with(0, validation_samples(config_.data)).input);
  std::vector<double> values = {own.entropy, own.centre_share, own.deviation};
  values.insert(values.end(), own.layer_share.begin(), own.layer_share.end());
  const torch::Tensor sums = torch::tensor(values, torch::kFloat64) * training_set_.batch_share();
  group_.sum({sums}, "looking at the kernels");
  const double* mean = sums.data_ptr<double>();
  row["kernel_entropy"] = *mean++;
  row["kernel_centre_share"] = *mean++;
  const double deviation = *mean++;
  for (size_t i = 1; i <= own.layer_share.size(); ++i) row[fmt::format("kernel_layer_share_{}", i)] = *mean++;
  // Where the best so far has such kernels, they are what the data ask for.
  if (config_.watch.enabled && row["kernel_entropy"] < config_.watch.entropy && !best_unsaved_)
    collapse_ = fmt::format("the kernels' mean entropy is {:.3g} nats, below {:g}: they have become one tap",
                            row["kernel_entropy"], config_.watch.entropy);
  if (config_.watch.enabled && deviation < kLeastDeviation) {
    collapse_ = fmt::format(
        "all pixels have the same kernel (relative deviation {:.2g}): nothing is learnt any more", deviation);
    forget_unsaved_best();  // early in a run even this may be the best so far, but it leads nowhere
    if (state_.best_step == 0) state_.watch.calm_step = 0;  // nor may what was saved since it was lost
  }
}

/// Collective. The state becomes that of the best checkpoint; without one, of the newest from before the
/// losses rose; without any, the beginning.
void Trainer::load_before_collapse() {
  const TrainingState collapsed = state_;
  optimizer_.adam().state().clear();
  if (group_.is_root()) {
    const auto checkpoint = checkpoints_.newest_whole_until(
        collapsed.best_step > 0 ? collapsed.best_step : collapsed.watch.calm_step);
    if (checkpoint) {
      state_ = read_checkpoint(*checkpoint, *network_, optimizer_);
    } else {
      state_ = TrainingState{};
      copy_parameters(*make_initial_network(config_, true), *network_);
      copy_parameters(*network_, optimizer_.average().network());
    }
    state_.dataset = collapsed.dataset;
    state_.crops_per_step = collapsed.crops_per_step;
    checkpoints_.go_back_to(state_.step);
    if (state_.step > 0) check_best();
  }
  state_ = share_checkpoint(state_, *network_, optimizer_, group_);
  state_.rollbacks = collapsed.rollbacks;
}

/// Collective. Crops follow from the step, so the same come again, at another rate. Nothing is saved: a run
/// that is killed before its next checkpoint continues from the one that this returns to, and collapses and
/// returns again.
void Trainer::go_back() {
  const int64_t step = state_.step;
  const std::string why = std::exchange(collapse_, "");
  load_before_collapse();
  const bool given_up = state_.rollbacks >= config_.watch.retries;
  if (!given_up) ++state_.rollbacks;
  saved_ = before_skips_ = state_;
  best_unsaved_ = false;
  if (group_.is_root()) log_.emplace(run_, state_.step, config_.network.layers);
  timed_steps_ = 0;
  timed_since_ = std::chrono::steady_clock::now();
  const std::string what = fmt::format("the training collapsed by step {}: {}", step, why);
  if (given_up)
    fail(
        "{}. It has gone back {} times before, down to {:g} of the learning rate, and is at step {} again; "
        "in a "
        "new run, lower optimizer.learning_rate, set optimizer.clip_norm or try another seed (watch.enabled="
        "false trains on regardless)",
        what, state_.rollbacks, rate_factor(), state_.step);
  if (group_.is_root())
    spdlog::warn("{}. Going back to step {}, with {:g} of the learning rate ({} of {} times)", what,
                 state_.step, rate_factor(), state_.rollbacks, config_.watch.retries);
}

}  // namespace ld
