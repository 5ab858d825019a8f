// Training on clips: networks that keep nothing from frame to frame take them for so many single frames,
// networks that remember go through them in order.
#include <gtest/gtest.h>

#include "models/initialise.h"
#include "tests/support/expect_error.h"
#include "tests/training/tiny_training.h"
#include "training/optimizer/clip_pass.h"
#include "training/training_data.h"

namespace ld {
namespace {

TEST(ClipTraining, TheLossIsTheMeanOverAllFrames) {
  const TemporaryFolder folder;
  const TrainConfig config = two_sequences(folder.path());
  TrainingSet set = make_training_set(config);
  EXPECT_EQ(set.batches_per_epoch(), 2) << "four clips of three frames, two a batch";
  const std::shared_ptr<Network> network = make_network(config.network);
  initialise(*network, 1);
  const Loss loss = make_loss("smape");
  const Batch batch = set.batch(0);
  ASSERT_EQ(batch.by_clip(batch.reference).sizes(), (std::vector<int64_t>{2, 3, 3, 8, 8}));
  double sum = 0;
  for (int64_t i = 0; i < 6; ++i) {
    const torch::NoGradGuard no_graph;
    const NetworkInput frame = {batch.input.features.narrow(0, i, 1), batch.input.radiance.narrow(0, i, 1),
                                batch.input.valid.narrow(0, i, 1)};
    sum += loss(network->forward(frame), batch.reference.narrow(0, i, 1)).item<double>();
  }
  ProcessGroup alone{ProcessGroupOptions{}};
  Optimizer optimizer(network, config.optimizer);
  const Optimizer::Outcome outcome = optimizer.step(set, 0, make_clip_loss({}, loss), 0.01, 1, alone);
  EXPECT_TRUE(outcome.taken);
  EXPECT_NEAR(outcome.loss, sum / 6, 1e-5);
}

TEST(ClipTraining, ARunContinuesWithTheClipsThatItWouldHaveHad) {
  const TemporaryFolder folder;
  TrainConfig config = two_sequences(folder / "data");
  config.data.samples = {1, 2};
  config.data.workers = 2;
  Trainer whole(config, folder / "whole");
  whole.train();
  EXPECT_EQ(whole.state().step, 4);
  EXPECT_EQ(whole.total_steps(), 1000 * 2);
  config.run.max_steps = 3;
  Trainer(config, folder / "parts").train();
  config.run.max_steps = 4;
  Trainer(config, folder / "parts").train();
  EXPECT_TRUE(last_checkpoint(folder / "whole") == last_checkpoint(folder / "parts"));
  config.data.clip = 2;
  EXPECT_ERROR(Trainer(config, folder / "parts"), "there 'clip: 3', here 'clip: 2'");
}

/// The same with a network that remembers.
TrainConfig remembering_config(const std::filesystem::path& data) {
  TrainConfig config = two_sequences(data);
  config.network.name = "layer_history";
  config.network.features = {"radiance", "normal", "depth"};  // nothing moves
  config.network.history = {4};
  config.clip_loss = {0.8, 0, 0.1, 2};
  return config;
}

std::shared_ptr<Network> network_of(const TrainConfig& config) {
  std::shared_ptr<Network> network = make_network(config.network);
  initialise(*network, 1);
  return network;
}

// Unrolled with its graph, clips give the bits that their frames give one after the other.
TEST(ClipTraining, FrameByFrameIsUnrolledBitForBit) {
  const TemporaryFolder folder;
  const TrainConfig config = remembering_config(folder.path());
  TrainingSet set = make_training_set(config);
  const std::shared_ptr<Network> network = network_of(config);
  const Batch batch = set.batch(0);
  const torch::Tensor unrolled = batch.by_clip(compare_clips(*network, batch).predicted);
  ASSERT_EQ(unrolled.sizes(), (std::vector<int64_t>{2, 3, 3, 8, 8}));
  NetworkState state;
  for (int64_t f = 0; f < 3; ++f) {
    const NetworkInput frames = frame_of_clips(batch.input, batch.clip, f);
    EXPECT_TRUE(network->forward(frames, state).equal(unrolled.select(1, f))) << f;
    EXPECT_EQ(f > 0, !network->forward(frames).equal(unrolled.select(1, f))) << f;
  }
}

TEST(ClipTraining, TruncationCutsGradientsAndNothingElse) {
  const TemporaryFolder folder;
  const TrainConfig config = remembering_config(folder.path());
  TrainingSet set = make_training_set(config);
  const Batch batch = set.batch(0);
  // Of the last frame's picture, in the first layer's weights, which all frames use.
  const auto gradient = [&](int64_t truncation, torch::Tensor& pictures) {
    const std::shared_ptr<Network> network = network_of(config);
    pictures = compare_clips(*network, batch, truncation).predicted;
    const torch::Tensor last = batch.by_clip(pictures).select(1, 2);
    return torch::autograd::grad({last.square().sum()}, {network->parameters()[0]})[0];
  };
  torch::Tensor whole, cut, at_third;
  const torch::Tensor through_time = gradient(0, whole), of_last_frame = gradient(1, cut);
  EXPECT_FALSE(through_time.equal(of_last_frame));
  EXPECT_TRUE(gradient(2, at_third).equal(of_last_frame));
  EXPECT_TRUE(whole.equal(cut) && whole.equal(at_third));
}

TEST(ClipTraining, ANetworkThatRemembersContinuesBitForBit) {
  const TemporaryFolder folder;
  TrainConfig config = remembering_config(folder / "data");
  config.optimizer.truncation = 2;
  Trainer whole(config, folder / "whole");
  whole.train();
  config.run.max_steps = 3;
  Trainer(config, folder / "parts").train();
  config.run.max_steps = 4;
  Trainer(config, folder / "parts").train();
  EXPECT_TRUE(last_checkpoint(folder / "whole") == last_checkpoint(folder / "parts"));
  config.optimizer.truncation = 0;
  EXPECT_ERROR(Trainer(config, folder / "parts"), "truncation: 2");
}

TEST(ClipTraining, StillFramesHaveNoClips) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 4);
  TrainConfig config = tiny_config(folder / "data", 4);
  config.data.clip = 2;
  EXPECT_ERROR(Trainer(config, folder / "run"), "data.clip: no 2 frames of ");
  EXPECT_FALSE(std::filesystem::exists(folder / "run"));
}

}  // namespace
}  // namespace ld
