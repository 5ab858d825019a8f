// How a Trainer saves its run, and what it goes back to when the training has collapsed.
#include <limits>
#include <thread>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/log.h"
#include "training/fine_tuning.h"
#include "training/trainer.h"
#include "training/training_data.h"

namespace ld {
namespace {

/// Pauses before the last checkpoint is tried again, seconds.
constexpr double kPauses[] = {0.25, 1, 2};

}  // namespace

/// On rank 0. `best` must name the checkpoint that the state says; where that is lost, the next validation
/// decides anew.
void Trainer::check_best(TrainingState& state) {
  if (validation_.empty()) {
    checkpoints_.restore_best(state.step);
  } else if (state.best_step > 0 && !checkpoints_.restore_best(state.best_step)) {
    spdlog::warn("until a validation finds a better one, step {} counts as the best", state.step);
    checkpoints_.restore_best(state.step);
    state.best_step = state.step;
    state.best_score = std::numeric_limits<double>::infinity();
  }
}

void Trainer::write_checkpoint() {
  const bool best = course_.best_is_unsaved();
  nlohmann::ordered_json provenance = {{"steps", state().step},
                                       {"dataset", state().dataset},
                                       {"program", "ld_train " LD_VERSION},
                                       {"seed", config_.seed},
                                       {"loss", config_.loss}};
  if (best) provenance["validation_loss"] = state().best_score;
  checkpoints_.write(
      state().step,
      [&](const std::filesystem::path& folder) {
        write_checkpoint_files(folder, state(), *network_, optimizer_, provenance.dump());
      },
      best || validation_.empty());
}

/// False when the checkpoint could not be written, which is reported: the run goes on.
bool Trainer::save() {
  if (group_.is_root()) {
    try {
      log_->flush();
      write_checkpoint();
    } catch (const Error& error) {
      spdlog::warn("the checkpoint of step {} is not saved: {}; the newest one is of step {}", state().step,
                   error.what(), course_.saved_step());
      course_.not_saved();
      return false;
    }
  }
  course_.saved();
  return true;
}

void Trainer::save_at_end() {
  if (save()) return;
  for (const double pause : kPauses) {
    std::this_thread::sleep_for(std::chrono::duration<double>(pause));
    if (save()) return;
  }
  fail(
      "steps {} to {} are lost: no checkpoint could be written, as reported above; make room in {} and "
      "start the same command again",
      course_.saved_step() + 1, state().step, run_.string());
}

/// Saves what was done when an error ends the run. Of a training that has collapsed there is nothing to save,
/// and while it goes back its weights may already be those of another step.
void Trainer::rescue() {
  if (state().step <= course_.saved_step() || !course_.collapse().empty()) return;
  try {
    write_checkpoint();
    spdlog::warn("step {} is saved before the run ends", state().step);
  } catch (const Error& error) {
    spdlog::warn("step {} could not be saved: {}", state().step, error.what());
  }
}

/// Collective. Network, optimiser and the state returned become those of the newest checkpoint that is good;
/// without any, those of the beginning.
TrainingState Trainer::load_last_good() {
  TrainingState good;
  optimizer_.adam().state().clear();
  if (group_.is_root()) {
    if (const auto checkpoint = checkpoints_.newest_whole_until(course_.last_good_step())) {
      good = read_checkpoint(*checkpoint, *network_, optimizer_);
    } else {
      copy_parameters(*make_initial_network(config_, true), *network_);
      copy_parameters(*network_, optimizer_.average().network());
    }
    checkpoints_.go_back_to(good.step);
    if (good.step > 0) check_best(good);
  }
  return share_checkpoint(good, *network_, optimizer_, group_);
}

/// Collective. Crops follow from the step, so the same come again, at another rate. Nothing is saved: a run
/// that is killed before its next checkpoint continues from the one that this returns to, and collapses and
/// returns again.
void Trainer::go_back() {
  const std::string what =
      fmt::format("the training collapsed by step {}: {}", state().step, course_.collapse());
  const bool may_try_again = course_.gone_back(load_last_good());
  row_.clear();
  if (group_.is_root()) log_.emplace(run_, state().step, config_.network.layers);
  timer_.start();
  if (!may_try_again)
    fail(
        "{}. It has gone back {} times before, down to {:g} of the learning rate, and is at step {} again; "
        "in a new run, lower optimizer.learning_rate, set optimizer.clip_norm or try another seed "
        "(watch.enabled=false trains on regardless)",
        what, state().rollbacks, state().rate_factor(), state().step);
  if (group_.is_root())
    spdlog::warn("{}. Going back to step {}, with {:g} of the learning rate ({} of {} times)", what,
                 state().step, state().rate_factor(), state().rollbacks, config_.watch.retries);
}

}  // namespace ld
