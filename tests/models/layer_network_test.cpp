// What the layered denoiser hands out between its stages.
#include "models/networks/layer_network.h"

#include <gtest/gtest.h>

#include "tests/models/small_network.h"

namespace ld {
namespace {

using torch::Tensor;

class LayerStagesTest : public ::testing::TestWithParam<const char*> {
 protected:
  LayerStagesTest() {
    config_.layers = 3;
    config_.compositing = GetParam();
    network_ = std::dynamic_pointer_cast<LayerNetwork>(small_network(config_, torch::kFloat32));
    input_ = random_input(config_, 1, 4, 6, 5, torch::kFloat32);
  }
  NetworkConfig config_ = small_config();
  std::shared_ptr<LayerNetwork> network_;
  NetworkInput input_;
};

TEST_P(LayerStagesTest, AreWhatTheNetworkComputes) {
  const LayerStages stages = network_->stages(input_);
  EXPECT_TRUE(stages.output.equal(network_->forward(input_)));
  EXPECT_EQ(stages.embedding.sizes(), (std::vector<int64_t>{1, 4, 5, 6, 5}));
  EXPECT_EQ(stages.context.sizes(), (std::vector<int64_t>{1, 3, 6, 5}));
  EXPECT_EQ(stages.partition_logits.sizes(), (std::vector<int64_t>{1, 4, 3, 6, 5}));
  EXPECT_EQ(stages.pictures.unfiltered_radiance.sizes(), (std::vector<int64_t>{1, 3, 3, 6, 5}));
  EXPECT_EQ(stages.pictures.radiance.sizes(), (std::vector<int64_t>{1, 3, 3, 6, 5}));
  EXPECT_EQ(stages.pictures.opacity.sizes(), (std::vector<int64_t>{1, 3, 1, 6, 5}));
  EXPECT_EQ(stages.pictures.weight.sizes(), (std::vector<int64_t>{1, 3, 1, 6, 5}));
}

TEST_P(LayerStagesTest, TheLayersMakeTheOutput) {
  const LayerStages stages = network_->stages(input_);
  expect_near((stages.pictures.weight * stages.pictures.radiance / stages.pictures.opacity).sum(1),
              stages.output, 1e-5);
  expect_near(stages.pictures.weight.sum(1), torch::ones({1, 1, 6, 5}), 1e-5);
  EXPECT_GE(stages.pictures.weight.min().item<double>(), 0);
  EXPECT_GE(stages.pictures.opacity.min().item<double>(), 0);
  EXPECT_LE(stages.pictures.opacity.max().item<double>(), 1 + 1e-6);
}

// Each pixel's mean radiance is what its unfiltered layers make together.
TEST_P(LayerStagesTest, TheUnfilteredLayersMakeTheNoisyPicture) {
  const LayerStages stages = network_->stages(input_);
  Tensor mean;
  if (config_.compositing == "weighted") {
    mean = (stages.layers.log_n.exp().unsqueeze(2) * stages.pictures.unfiltered_radiance).sum(1);
  } else {
    Tensor visible = torch::ones({1, 1, 6, 5});
    mean = torch::zeros({1, 3, 6, 5});
    for (int64_t l = 0; l < 3; ++l) {
      mean = mean + visible * stages.pictures.unfiltered_radiance.select(1, l);
      visible = visible * (1 - stages.layers.opacity.select(1, l));
    }
  }
  const Tensor count = input_.valid.sum(1);
  expect_near(mean, (input_.radiance * input_.valid).sum(1) / count.clamp_min(1), 1e-5);
}

INSTANTIATE_TEST_SUITE_P(Compositing, LayerStagesTest, ::testing::Values("alpha", "weighted"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace ld
