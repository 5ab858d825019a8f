#include "training/optimizer/optimizer.h"

#include <cmath>

#include "training/optimizer/clip_pass.h"
#include "training/optimizer/stage_scheme.h"

namespace ld {
namespace {

/// Adam keeps squares of gradients in float32, which must not overflow.
constexpr double kLargestGradient = 1e18;

torch::optim::AdamOptions adam_options(const OptimizerConfig& config) {
  return torch::optim::AdamOptions(config.learning_rate)
      .betas({config.beta1, config.beta2})
      .eps(config.epsilon);
}

}  // namespace

double gradient_norm(const Network& network) {
  double square = 0;
  for (const torch::Tensor& parameter : network.parameters()) {
    if (!parameter.grad().defined()) continue;
    const double norm = torch::norm(parameter.grad(), 2, torch::kFloat64).item<double>();
    square += norm * norm;
  }
  return std::sqrt(square);
}

void forget_gradients(Network& network) {
  for (torch::Tensor& parameter : network.parameters()) parameter.mutable_grad().reset();
}

Optimizer::Optimizer(std::shared_ptr<Network> network, const OptimizerConfig& config)
    : network_(std::move(network)),
      config_(config),
      adam_(network_->parameters(), adam_options(config)),
      average_(network_, config.ema) {}

Optimizer::Outcome Optimizer::step(TrainingSet& set, int64_t step, const ClipLoss& loss, double rate,
                                   int64_t n, ProcessGroup& group) {
  Outcome outcome;
  outcome.loss = add_up(accumulate(set, step, loss), group);
  outcome.gradient = gradient_norm(*network_);
  // Adam would keep one NaN for ever, and clipping by norm turns an infinity into NaN.
  outcome.taken =
      std::isfinite(outcome.loss) && std::isfinite(outcome.gradient) && limit_gradient() < kLargestGradient;
  if (outcome.taken) {
    static_cast<torch::optim::AdamOptions&>(adam_.param_groups()[0].options()).lr(rate);
    decay_weights(rate);
    adam_.step();
    average_.update(n);
  }
  forget_gradients(*network_);
  return outcome;
}

/// Leaves this process's part of the gradient, and returns its part of the loss.
double Optimizer::accumulate(TrainingSet& set, int64_t step, const ClipLoss& loss) {
  const double share = set.batch_share() / static_cast<double>(config_.accumulate);
  double sum = 0;
  for (int64_t i = 0; i < config_.accumulate; ++i) {
    Batch batch = set.batch(step * config_.accumulate + i);
    if (needs_noisy(config_)) {
      const torch::Tensor part = batch_loss(*network_, batch, loss, config_) * share;
      part.backward();
      sum += part.item<double>();
    } else {
      sum += add_gradient(*network_, std::move(batch), loss, share, {config_.truncation, config_.recompute});
    }
  }
  return sum;
}

/// Adds the gradients of all processes up, and their losses; returns the loss.
double Optimizer::add_up(double loss, ProcessGroup& group) {
  if (group.size() == 1) return loss;
  std::vector<torch::Tensor> gradients;
  for (torch::Tensor& parameter : network_->parameters()) {
    if (!parameter.grad().defined()) parameter.mutable_grad() = torch::zeros_like(parameter);
    gradients.push_back(parameter.mutable_grad());
  }
  group.sum(gradients, "adding up the gradients");
  return group.sum(loss, "adding up the loss");
}

/// Applies the configured limits; returns the largest absolute gradient after them.
double Optimizer::limit_gradient() {
  const std::vector<torch::Tensor> parameters = network_->parameters();
  if (config_.clip_value > 0) torch::nn::utils::clip_grad_value_(parameters, config_.clip_value);
  if (config_.clip_norm > 0) {
    const double norm = gradient_norm(*network_);
    if (norm > config_.clip_norm)
      for (const torch::Tensor& parameter : parameters)
        if (parameter.grad().defined()) parameter.mutable_grad().mul_(config_.clip_norm / norm);
  }
  double largest = 0;
  for (const torch::Tensor& parameter : parameters)
    if (parameter.grad().defined() && parameter.numel() > 0)
      largest = std::max(largest, parameter.grad().abs().max().item<double>());
  return largest;
}

/// AdamW (Loshchilov and Hutter 2019, algorithm 2): the decay is apart from gradient and moments, so that
/// what is left is Adam, its state included. It pulls on weights alone: a bias sets no scale.
void Optimizer::decay_weights(double rate) {
  if (config_.weight_decay == 0) return;
  const torch::NoGradGuard no_graph;
  for (torch::Tensor& parameter : network_->parameters())
    if (parameter.dim() >= 2 && parameter.grad().defined()) parameter.mul_(1 - rate * config_.weight_decay);
}

}  // namespace ld
