#include "training/optimizer/optimizer.h"

#include <gtest/gtest.h>

#include "models/initialise.h"
#include "tests/training/tiny_training.h"
#include "training/training_data.h"

namespace ld {
namespace {

TEST(Optimizer, AdamwIsLibTorchsForWeightsAndAdamForBiases) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 4);
  TrainConfig config = tiny_config(folder / "data", 10);
  config.optimizer.name = "adamw";
  config.optimizer.weight_decay = 0.1;
  const std::shared_ptr<Network> network = make_network(config.network), other = make_network(config.network);
  initialise(*network, 1);
  copy_parameters(*network, *other);
  TrainingSet set = make_training_set(config);
  const Loss loss = make_loss("smape");
  ProcessGroup alone{ProcessGroupOptions{}};
  Optimizer ours(network, config.optimizer);

  std::vector<torch::Tensor> weights, biases;
  for (const torch::Tensor& parameter : other->parameters())
    (parameter.dim() >= 2 ? weights : biases).push_back(parameter);
  ASSERT_GE(weights.size(), 3u);
  ASSERT_GE(biases.size(), 3u);
  const auto options = [](double decay) { return torch::optim::AdamWOptions(0.02).weight_decay(decay); };
  torch::optim::AdamW theirs(
      {torch::optim::OptimizerParamGroup(weights, std::make_unique<torch::optim::AdamWOptions>(options(0.1))),
       torch::optim::OptimizerParamGroup(biases, std::make_unique<torch::optim::AdamWOptions>(options(0)))},
      options(0));

  for (int64_t step = 0; step < 5; ++step) {
    EXPECT_TRUE(ours.step(set, step, make_clip_loss({}, loss), 0.02, step + 1, alone).taken);
    Batch batch = set.batch(step);
    loss(other->forward(std::move(batch.input)), batch.reference).backward();
    theirs.step();
    theirs.zero_grad();
    EXPECT_TRUE(all_parameters(*network).equal(all_parameters(*other))) << step;
  }
}

// Loss and gradient of accumulated batches are those of the larger batch, to rounding; so is the training.
TEST(Optimizer, AccumulatingTrainsAsTheLargerBatchDoes) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 9, 16, 3);
  TrainConfig config = tiny_config(folder / "data", 10);
  config.data.samples = {1, 3};
  const auto trained = [&](int64_t batch, int64_t accumulate) {
    config.data.batch = batch;
    config.optimizer.accumulate = accumulate;
    const std::shared_ptr<Network> network = make_network(config.network);
    initialise(*network, 1);
    TrainingSet set = make_training_set(config);
    ProcessGroup alone{ProcessGroupOptions{}};
    Optimizer optimizer(network, config.optimizer);
    std::vector<double> seen;
    // At first without a step, so that all see the same weights; then with small ones.
    for (int64_t step = 0; step < 12; ++step) {
      const Optimizer::Outcome outcome = optimizer.step(set, step, make_clip_loss({}, make_loss("smape")),
                                                        step < 6 ? 0 : 1e-4, step + 1, alone);
      seen.push_back(outcome.loss);
      seen.push_back(outcome.gradient);
    }
    return seen;
  };
  const std::vector<double> whole = trained(4, 1);
  for (const int64_t accumulate : {2, 4}) {
    const std::vector<double> parts = trained(4 / accumulate, accumulate);
    for (size_t i = 0; i < whole.size(); ++i)
      EXPECT_NEAR(parts[i] / whole[i], 1, i < 12 ? 1e-5 : 1e-3) << accumulate << " batches, number " << i;
  }
}

}  // namespace
}  // namespace ld
