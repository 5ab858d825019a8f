#include "training/trainer.h"

#include <chrono>
#include <cmath>

#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "core/signals.h"
#include "metrics/metric.h"
#include "training/run_folder.h"
#include "training/schedule.h"
#include "training/training_data.h"

namespace ld {
namespace {

/// A run with more such steps in a row has diverged.
constexpr int64_t kMostSkippedInARow = 100;

std::shared_ptr<Network> make_initial_network(const TrainConfig& config) {
  std::shared_ptr<Network> network = make_network(config.network);
  initialise_xavier(*network, config.seed);
  return network;
}

torch::optim::AdamOptions adam_options(const OptimizerConfig& config) {
  return torch::optim::AdamOptions(config.learning_rate)
      .betas({config.beta1, config.beta2})
      .eps(config.epsilon);
}

std::vector<std::string> log_columns() {
  std::vector<std::string> columns = {"epoch", "learning_rate", "train_loss", "seconds_per_step",
                                      "validation_loss"};
  for (const Metric& metric : metrics()) columns.push_back(metric.name);
  return columns;
}

}  // namespace

Trainer::Trainer(TrainConfig config, std::filesystem::path run)
    : config_(resolve_features(std::move(config), run)),
      run_(std::move(run)),
      training_set_(make_training_set(config_)),
      validation_(make_validation_stores(config_)),
      network_(make_initial_network(config_)),
      loss_(make_loss(config_.loss)),
      optimizer_(network_->parameters(), adam_options(config_.optimizer)),
      checkpoints_(run_),
      total_steps_(config_.epochs * training_set_.steps_per_epoch()) {
  claim_run_folder(run_, config_);
  add_log_file(run_ / "train.log");
  state_.dataset = manifests_checksum(config_.data);
  int64_t parameters = 0;
  for (const torch::Tensor& parameter : network_->parameters()) parameters += parameter.numel();
  spdlog::info("network '{}' with {} parameters; {} steps of {} crops of {}x{}; loss {}; {} threads",
               config_.network.name, parameters, total_steps_, config_.data.batch, config_.data.crop,
               config_.data.crop, config_.loss, torch::get_num_threads());
  if (validation_.empty())
    spdlog::warn("the data has no validation split: `best` will be the last checkpoint");
  resume();
}

void Trainer::resume() {
  const std::optional<std::filesystem::path> checkpoint = checkpoints_.last();
  if (!checkpoint) return;
  const std::string dataset = state_.dataset;
  state_ = read_checkpoint(*checkpoint, *network_, optimizer_);
  spdlog::info("continuing from {} at step {}", checkpoint->string(), state_.step);
  if (state_.dataset != dataset) {
    spdlog::warn("the data set has changed since that checkpoint: its manifest had the checksum {}, now {}",
                 state_.dataset, dataset);
    state_.dataset = dataset;
  }
}

void Trainer::train() {
  const int64_t last_step =
      config_.run.max_steps > 0 ? std::min(config_.run.max_steps, total_steps_) : total_steps_;
  EventLog events(run_ / "metrics.csv", log_columns(), state_.step);
  Progress progress("training", last_step, state_.step);
  int64_t written_step = state_.step, measured_steps = 0;
  double loss_sum = 0;
  auto measured_since = std::chrono::steady_clock::now();

  while (state_.step < last_step && !stop_requested()) {
    const double rate =
        learning_rate(config_.optimizer, state_.step, training_set_.steps_per_epoch(), total_steps_);
    static_cast<torch::optim::AdamOptions&>(optimizer_.param_groups()[0].options()).lr(rate);
    const double loss = take_step();
    loss_sum += loss;
    ++measured_steps;
    progress.advance(1, fmt::format("loss {:.4f}", loss));

    const bool last = state_.step == last_step;
    std::map<std::string, double> row;
    bool best = false;
    if (!validation_.empty() && (state_.step % config_.run.validate_every == 0 || last)) {
      row = validate();
      best = note_score(row);
    }
    if (state_.step % config_.run.log_every == 0 || last || !row.empty()) {
      const auto now = std::chrono::steady_clock::now();
      row["epoch"] = static_cast<double>(state_.step) / static_cast<double>(training_set_.steps_per_epoch());
      row["learning_rate"] = rate;
      row["train_loss"] = loss_sum / static_cast<double>(measured_steps);
      row["seconds_per_step"] =
          std::chrono::duration<double>(now - measured_since).count() / static_cast<double>(measured_steps);
      events.write(state_.step, row);
      loss_sum = 0;
      measured_steps = 0;
      measured_since = now;
    }
    if (best || last || state_.step % config_.run.checkpoint_every == 0) {
      checkpoints_.write(state_, *network_, optimizer_, best || validation_.empty());
      written_step = state_.step;
    }
  }
  // Stopped by a signal between two checkpoints.
  if (written_step != state_.step) checkpoints_.write(state_, *network_, optimizer_, validation_.empty());
}

double Trainer::take_step() {
  const Batch batch = training_set_.batch(state_.step);
  optimizer_.zero_grad();
  const torch::Tensor loss = loss_(network_->forward(batch.input), batch.reference);
  loss.backward();
  ++state_.step;
  const double value = loss.item<double>();
  // Adam would keep one NaN for ever, and clipping by norm turns an infinity into NaN: such a step is not
  // taken.
  if (std::isfinite(value) && limit_gradients()) {
    optimizer_.step();
    ++state_.optimizer_steps;
    skipped_in_a_row_ = 0;
    return value;
  }
  spdlog::warn("step {}: loss {} with gradients that are not all finite; step skipped", state_.step, value);
  if (++skipped_in_a_row_ > kMostSkippedInARow)
    fail(
        "step {}: {} steps in a row had no finite gradient: the training diverged; lower "
        "optimizer.learning_rate and "
        "start a new run",
        state_.step, skipped_in_a_row_);
  return value;
}

/// Applies the limits of the optimiser's configuration; false when a gradient is not finite.
bool Trainer::limit_gradients() {
  double square = 0;
  for (const torch::Tensor& parameter : network_->parameters())
    if (parameter.grad().defined()) square += parameter.grad().square().sum(torch::kFloat64).item<double>();
  if (!std::isfinite(square)) return false;
  if (config_.optimizer.clip_value > 0)
    torch::nn::utils::clip_grad_value_(network_->parameters(), config_.optimizer.clip_value);
  if (config_.optimizer.clip_norm > 0)
    torch::nn::utils::clip_grad_norm_(network_->parameters(), config_.optimizer.clip_norm);
  return true;
}

/// Loss and metrics on the whole frames of the validation splits, means over the frames.
std::map<std::string, double> Trainer::validate() {
  std::map<std::string, double> sums;
  const torch::NoGradGuard no_graph;
  double count = 0;
  for (const std::unique_ptr<FrameStore>& store : validation_)
    for (size_t i = 0; i < store->size(); ++i, ++count) {
      Augmentation whole;
      whole.width = store->width(i);
      whole.height = store->height(i);
      Batch batch =
          make_batch({{store->get_intact(i, store->get(i), whole.tiles()), whole}}, config_.network.features);
      const torch::Tensor denoised = network_->forward(std::move(batch.input));
      sums["validation_loss"] += loss_(denoised, batch.reference).item<double>();
      const Image image = to_image(denoised.squeeze(0)), reference = to_image(batch.reference.squeeze(0));
      for (const Metric& metric : metrics()) sums[metric.name] += metric.compute(image, reference);
    }
  for (auto& [name, sum] : sums) sum /= count;
  return sums;
}

/// Remembers the lowest validation loss; true when this is it.
bool Trainer::note_score(const std::map<std::string, double>& scores) {
  const double loss = scores.at("validation_loss");
  const bool best = loss < state_.best_score;
  std::string text;
  for (const Metric& metric : metrics())
    text += fmt::format(", {} {:.{}f}", metric.title, scores.at(metric.name), metric.digits);
  spdlog::info("step {}: validation loss {:.4f}{}{}", state_.step, loss, best ? " (best)" : "", text);
  if (best) {
    state_.best_score = loss;
    state_.best_step = state_.step;
  }
  return best;
}

}  // namespace ld
