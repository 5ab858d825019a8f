// Training of the recurrent autoencoder: clips unrolled and frame by frame, back-propagation that recomputes,
// and resuming.
#include <gtest/gtest.h>

#include <cmath>

#include "losses/loss.h"
#include "models/initialise.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"
#include "tests/training/tiny_training.h"
#include "training/optimizer/clip_pass.h"

namespace ld {
namespace {

using torch::Tensor;

const ClipLossConfig kRecurrentLoss = {0.8, 0.1, 0.1, 2};

/// Clips of still scenes: a texture, and light in squares of 2x2 pixels, none like its neighbours, of which
/// every frame has one sample of exponential noise. So there is little to average in a frame and much over
/// frames.
Batch still_clips(uint32_t seed, int64_t clips, int64_t clip, int64_t side,
                  torch::ScalarType type = torch::kFloat32) {
  const NetworkConfig config = small_recurrent_config();
  const auto of_frames = [&](const Tensor& of_clips) {
    std::vector<int64_t> sizes = of_clips.sizes().vec();
    sizes.insert(sizes.begin() + 1, clip);
    return of_clips.unsqueeze(1).expand(sizes).flatten(0, 1);
  };
  const int64_t squares = (side + 1) / 2;
  const Tensor light = random_uniform({clips, 3, squares, squares}, seed, 0.1, 2)
                           .repeat_interleave(2, 2)
                           .repeat_interleave(2, 3)
                           .narrow(2, 0, side)
                           .narrow(3, 0, side);
  const Tensor albedo = random_uniform({clips, 3, side, side}, seed + 1, 0.2, 0.9);
  const Tensor noise = -random_uniform({clips * clip, 1, side, side}, seed + 2, 1e-6, 1).log();
  Batch batch;
  batch.clip = clip;
  batch.reference = of_frames(light * albedo).to(type).contiguous();
  batch.input.radiance = (of_frames(light * albedo) * noise).unsqueeze(1).to(type).contiguous();
  batch.input.valid = torch::ones({clips * clip, 1, 1, side, side}, type);
  batch.input.features =
      torch::zeros({clips * clip, 1, channel_count(config.features), side, side}, torch::kFloat64);
  const auto set = [&](const char* name, const Tensor& values) {
    batch.input.features.narrow(2, first_channel(config.features, name), values.size(1)) =
        values.unsqueeze(1);
  };
  set("albedo", of_frames(albedo));
  set("depth", torch::full({clips * clip, 1, side, side}, 0.5, torch::kFloat64));
  batch.input.features = batch.input.features.to(type);
  return batch;
}

ClipLoss recurrent_loss() {
  return make_clip_loss(kRecurrentLoss, make_loss("l1"), /*in_powers=*/true);
}

TEST(RecurrentTraining, FrameByFrameIsUnrolledBitForBit) {
  const auto network = small_network(small_recurrent_config(), torch::kFloat32);
  const Batch batch = still_clips(1, 2, 5, 17);
  const Compared unrolled = compare_clips(*network, batch);
  NetworkState state;
  for (int64_t f = 0; f < batch.clip; ++f) {
    const NetworkInput frames = frame_of_clips(batch.input, batch.clip, f);
    const Compared compared = network->compare(frames, batch.by_clip(batch.reference).select(1, f), state);
    EXPECT_TRUE(compared.predicted.equal(batch.by_clip(unrolled.predicted).select(1, f))) << f;
    EXPECT_TRUE(compared.picture.equal(batch.by_clip(unrolled.picture).select(1, f))) << f;
    EXPECT_TRUE(compared.target.equal(batch.by_clip(unrolled.target).select(1, f))) << f;
  }
}

TEST(RecurrentTraining, RecomputingFramesGivesTheSameGradient) {
  NetworkConfig history = small_config();
  history.name = "layer_history";
  history.features = small_recurrent_config().features;
  history.demodulation = "albedo";
  for (const NetworkConfig& config : {small_recurrent_config(), history})
    for (const int64_t truncation : {0, 2, 1}) {
      const auto network = small_network(config, torch::kFloat64);
      const Batch batch = still_clips(3, 2, 5, 16, torch::kFloat64);
      const ClipLoss loss = recurrent_loss();
      const auto gradients = [&](bool recompute, double& value) {
        forget_gradients(*network);
        value = add_gradient(*network, batch, loss, 0.5, {truncation, recompute});
        std::vector<Tensor> all;
        for (const Tensor& parameter : network->parameters()) all.push_back(parameter.grad());
        return all;
      };
      double kept = 0, recomputed = 0;
      const std::vector<Tensor> expected = gradients(false, kept), found = gradients(true, recomputed);
      EXPECT_NEAR(recomputed, kept, 1e-12) << config.name;
      for (size_t i = 0; i < expected.size(); ++i) {
        ASSERT_EQ(found[i].defined(), expected[i].defined()) << config.name;
        if (!found[i].defined()) continue;
        const double largest = expected[i].abs().max().item<double>();
        EXPECT_LE((found[i] - expected[i]).abs().max().item<double>(), 1e-11 * (largest + 1e-3))
            << config.name << " truncation " << truncation << " parameter " << i;
      }
    }
}

TEST(RecurrentTraining, GradientsOfTheWholeLossAgreeWithFiniteDifferences) {
  const auto network = small_network(small_recurrent_config(), torch::kFloat64);
  const Batch batch = still_clips(5, 1, 3, 16, torch::kFloat64);
  const ClipLoss loss = recurrent_loss();
  const auto value = [&] {
    const torch::NoGradGuard no_graph;
    const Compared compared = compare_clips(*network, batch);
    return loss(compared.predicted, compared.target, batch.clip).item<double>();
  };
  forget_gradients(*network);
  add_gradient(*network, batch, loss, 1, {});
  for (const auto& parameter : network->named_parameters()) {
    double* x = parameter.value().data_ptr<double>();
    const double before = *x, h = 1e-6;
    *x = before + h;
    const double above = value();
    *x = before - h;
    const double below = value();
    *x = before;
    // Absolute values bend where a difference is 0; of the few of 768 that may be so near, little is left.
    EXPECT_NEAR(parameter.value().grad().flatten()[0].item<double>(), (above - below) / (2 * h), 1e-5)
        << parameter.key();
  }
}

TrainConfig recurrent_run(const std::filesystem::path& data) {
  TrainConfig config = two_sequences(data);
  config.data.crop = 16;
  config.data.samples = {1, 1};
  config.data.reversal = true;
  config.data.tint = 2;
  config.data.stop = 0.3;
  config.data.freeze = 0.3;
  config.network = small_recurrent_config();
  config.network.features = {"normal", "depth", "roughness", "albedo", "specular"};
  config.loss = "l1";
  config.clip_loss = kRecurrentLoss;
  config.optimizer.schedule = "inverse_root";
  config.optimizer.ramp_epochs = 3;
  return config;
}

TEST(RecurrentTraining, ContinuesBitForBit) {
  const TemporaryFolder folder;
  TrainConfig config = recurrent_run(folder / "data");
  for (const bool recompute : {false, true}) {
    const std::string whole = recompute ? "whole" : "whole_kept", parts = recompute ? "parts" : "parts_kept";
    config.optimizer.recompute = recompute;
    config.run.max_steps = 12;
    Trainer(config, folder / whole).train();
    for (const int64_t steps : {3, 7, 12}) {
      config.run.max_steps = steps;
      Trainer(config, folder / parts).train();
    }
    EXPECT_TRUE(last_checkpoint(folder / whole) == last_checkpoint(folder / parts));
  }
}

TEST(RecurrentTraining, ValidatesInTheDomainOfItsLoss) {
  const TemporaryFolder folder;
  const TrainConfig config = recurrent_run(folder / "data");
  const auto network = small_network(config.network, torch::kFloat32);
  std::vector<std::unique_ptr<FrameStore>> stores;
  stores.push_back(std::make_unique<FrameStore>(folder / "data", "validation", config.network.features,
                                                CacheOptions{"none", 0}));
  Validation validation(std::move(stores), 1);
  ProcessGroup alone{ProcessGroupOptions{}};
  const auto result = validation.run(*network, make_loss("l1"), alone, [] { return false; });
  const Batch whole = validation.middle_of_largest(config.network.features, 16);
  const torch::NoGradGuard no_graph;
  NetworkState state;
  const Compared compared = network->compare(whole.input, whole.reference, state);
  EXPECT_NEAR(result->scores.at("validation_loss"),
              (compared.predicted - compared.target).abs().mean().item<double>(), 1e-6);
}

}  // namespace
}  // namespace ld
