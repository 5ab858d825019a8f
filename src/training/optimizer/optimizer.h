// One step of the training: gradient of the mean loss over the step's batches, limits, Adam or AdamW,
// averaged weights.
#pragma once

#include <torch/torch.h>

#include <memory>

#include "dataset/training_set.h"
#include "losses/clip_loss.h"
#include "models/network.h"
#include "training/distributed/process_group.h"
#include "training/optimizer/weight_average.h"
#include "training/run/config.h"

namespace ld {

class Optimizer {
 public:
  Optimizer(std::shared_ptr<Network> network, const OptimizerConfig& config);

  struct Outcome {
    double loss = 0;      // mean over all batches and processes
    double gradient = 0;  // norm of the gradient before it was limited
    bool taken = false;   // false: loss or gradient are not finite, or too large for Adam's squares; neither
                          // weights nor moments nor averages have changed
  };

  /// Trains on batches step * accumulate ... of the set, at this learning rate. If the step is taken, it is
  /// the n-th one taken (from 1). All processes decide alike, because they look at the same sums.
  Outcome step(TrainingSet& set, int64_t step, const ClipLoss& loss, double rate, int64_t n,
               ProcessGroup& group);

  torch::optim::Adam& adam() { return adam_; }
  WeightAverage& average() { return average_; }
  const WeightAverage& average() const { return average_; }

 private:
  double accumulate(TrainingSet& set, int64_t step, const ClipLoss& loss);
  double add_up(double loss, ProcessGroup& group);
  double limit_gradient();
  void decay_weights(double rate);

  std::shared_ptr<Network> network_;
  OptimizerConfig config_;
  torch::optim::Adam adam_;
  WeightAverage average_;
};

/// Norm of all gradients together, in double: the squares of finite gradients do not overflow.
double gradient_norm(const Network& network);

/// Leaves no gradient behind.
void forget_gradients(Network& network);

}  // namespace ld
