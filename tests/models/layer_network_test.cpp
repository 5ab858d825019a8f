#include "models/layer_network.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "losses/loss.h"
#include "tests/models/small_network.h"
#include "tests/support/gradient_check.h"
#include "tests/support/scalar_reference.h"

namespace ld {
namespace {

using torch::Tensor;

Tensor expected_output(const Network& network, const NetworkInput& input) {
  reference::Parameters parameters;
  for (const auto& entry : network.named_parameters()) {
    const Tensor p = entry.value().detach().to(torch::kFloat64).contiguous();
    parameters[entry.key()] = {p.sizes().vec(), {p.data_ptr<double>(), p.data_ptr<double>() + p.numel()}};
  }
  reference::UNetLayout layout;
  const UNetConfig& unet = network.config().unet;
  for (const auto& block : unet.encoder) layout.encoder.push_back(int64_t(block.size()));
  for (const auto& block : unet.decoder) layout.decoder.push_back(int64_t(block.size()));
  layout.bottleneck = int64_t(unet.bottleneck.size());
  layout.bilinear = unet.upsampling == "bilinear";
  return to_tensor(reference::layer_network(to_grid(input.features), to_grid(input.radiance),
                                            to_grid(input.valid), parameters, layout))
      .squeeze(1);
}

NetworkInput to_type(const NetworkInput& input, torch::ScalarType type) {
  return {input.features.to(type), input.radiance.to(type), input.valid.to(type)};
}

TEST(LayerNetwork, AgreesWithTheScalarReference) {
  for (const int64_t layers : {1, 2, 3})
    for (const int64_t samples : {1, 3, 8})
      for (const auto& [h, w] : std::vector<std::pair<int64_t, int64_t>>{{1, 1}, {1, 2}, {5, 7}}) {
        NetworkConfig config = small_config();
        config.layers = layers;
        config.kernel_size = samples == 3 ? 5 : 3;
        config.unet.upsampling = samples == 8 ? "nearest" : "bilinear";
        const NetworkInput input = random_input(config, 2, samples, h, w, torch::kFloat64);
        const auto network = small_network(config, torch::kFloat64);
        const Tensor expected = expected_output(*network, input);
        EXPECT_LE(largest_difference(network->forward(input), expected), 1e-10) << layers << " " << samples;
        network->to(torch::kFloat32);
        const Tensor single = network->forward(to_type(input, torch::kFloat32));
        EXPECT_LE(largest_difference(single, expected), 4e-5 * 4) << layers << " " << samples;
      }
}

TEST(LayerNetwork, GradientsAgreeWithFiniteDifferences) {
  const NetworkConfig config = small_config();
  const auto network = small_network(config, torch::kFloat64);
  const NetworkInput input = random_input(config, 1, 3, 5, 6, torch::kFloat64);
  const Tensor reference_image = random_uniform({1, 3, 5, 6}, 7, 0, 4);
  std::vector<Tensor> inputs = network->parameters();
  inputs.push_back(variable(input.features));
  inputs.push_back(variable(input.radiance));
  const size_t count = inputs.size();
  const auto run = [&](const std::vector<Tensor>& v) {
    return network->forward({v[count - 2], v[count - 1], input.valid});
  };
  expect_gradients(run, inputs, 12);
  for (const std::string& name : loss_names())
    expect_gradients([&](const auto& v) { return make_loss(name)(run(v), reference_image); }, inputs, 2);
}

TEST(LayerNetwork, StagesAreWhatTheNetworkComputes) {
  const NetworkConfig config = small_config();
  LayerNetwork network(config);
  initialise_xavier(network, 1);
  const NetworkInput input = random_input(config, 1, 3, 6, 5, torch::kFloat32);
  const LayerStages stages = network.stages(input);
  EXPECT_TRUE(stages.output.equal(network.forward(input)));
  EXPECT_EQ(stages.embedding.sizes(), (std::vector<int64_t>{1, 3, 5, 6, 5}));
  EXPECT_EQ(stages.context.sizes(), (std::vector<int64_t>{1, 3, 6, 5}));
  EXPECT_EQ(stages.partition_logits.sizes(), (std::vector<int64_t>{1, 3, 2, 6, 5}));
  EXPECT_EQ(stages.radiance.sizes(), (std::vector<int64_t>{1, 2, 3, 6, 5}));
  expect_near(stages.radiance.select(1, 0) + stages.transmittance.select(1, 0) * stages.radiance.select(1, 1),
              stages.output, 1e-6);
}

TEST(LayerNetwork, AMaskedSampleIsLikeOneThatWasRemoved) {
  const NetworkConfig config = small_config();
  const auto network = small_network(config, torch::kFloat32);
  NetworkInput input = random_input(config, 1, 4, 6, 7, torch::kFloat32);
  input.valid.select(1, 2).zero_();  // its features keep their values: the mask alone must do
  const Tensor kept = torch::tensor({0, 1, 3});
  const NetworkInput removed = {input.features.index_select(1, kept), input.radiance.index_select(1, kept),
                                input.valid.index_select(1, kept)};
  EXPECT_TRUE(network->forward(input).equal(network->forward(removed)));
}

TEST(LayerNetwork, AConstantImageStaysConstantWithAnyWeights) {
  NetworkConfig config = small_config();
  config.layers = 3;
  for (const double scale : {1.0, 30.0, 1000.0}) {
    const auto network = small_network(config, torch::kFloat32);
    for (auto& entry : network->named_parameters())  // the last layers make the logits
      if (entry.key().find("1.weight") != std::string::npos) entry.value().detach().mul_(scale);
    NetworkInput input = random_input(config, 1, 3, 9, 11, torch::kFloat32);
    input.radiance = (input.valid * 2.5).expand({1, 3, 3, 9, 11}).contiguous();
    EXPECT_LE((network->forward(input) / 2.5 - 1).abs().max().item<double>(), 1e-5) << scale;
  }
}

TEST(LayerNetwork, ExtremeInputStaysFinite) {
  const NetworkConfig config = small_config();
  for (const double extreme : {0.0, 1e-40, 1e-38, 65504.0, 1e30, 3e38}) {
    const auto network = small_network(config, torch::kFloat32);
    NetworkInput input = random_input(config, 1, 3, 5, 6, torch::kFloat32);
    const Tensor where = random_uniform({1, 3, 1, 5, 6}, 8).gt(0.7).to(torch::kFloat32) * input.valid;
    input.radiance = input.radiance * (1 - where) + where * extreme;
    input.features = input.features * (1 - where) - where * extreme;
    for (const std::string& name : loss_names()) {
      network->zero_grad();
      const Tensor output = network->forward(input);
      make_loss(name)(output, torch::ones_like(output)).backward();
      EXPECT_TRUE(all_finite(output)) << extreme;
      for (const auto& entry : network->named_parameters())
        EXPECT_TRUE(all_finite(entry.value().grad())) << name << " " << extreme << " " << entry.key();
    }
  }
}

TEST(LayerNetwork, TwoRunsGiveTheSameBits) {
  NetworkConfig config = small_config();
  config.kernel_size = 9;
  const int threads = at::get_num_threads();
  const NetworkInput input = random_input(config, 2, 4, 17, 19, torch::kFloat32);
  for (const int count : {1, 2}) {
    at::set_num_threads(count);
    std::vector<Tensor> first;
    for (int repeat = 0; repeat < 3; ++repeat) {
      const auto network = small_network(config, torch::kFloat32);
      const Tensor output = network->forward(input);
      output.square().mean().backward();
      std::vector<Tensor> results = {output};
      for (const auto& parameter : network->parameters()) results.push_back(parameter.grad());
      if (repeat == 0) first = results;
      for (size_t i = 0; i < results.size(); ++i)
        EXPECT_TRUE(results[i].equal(first[i])) << count << " threads, " << i;
    }
  }
  at::set_num_threads(threads);
}

TEST(LayerNetwork, StripsAtInferenceGiveTheWholePicture) {
  NetworkConfig config = small_config();
  config.kernel_size =
      31;  // 961 taps of 2 layers in double: 256 MB of kernel logits are 49 rows of 352 pixels
  const auto network = small_network(config, torch::kFloat64);
  const NetworkInput input = random_input(config, 1, 1, 60, 352, torch::kFloat64);
  const Tensor whole = network->forward(input).detach();
  const c10::InferenceMode guard;
  const Tensor strips = network->forward(input);
  EXPECT_EQ(strips.sizes(), whole.sizes());
  EXPECT_LE(largest_difference(strips, whole), 1e-12);
}

TEST(LayerNetwork, BadShapesAreErrors) {
  const NetworkConfig config = small_config();
  const auto network = small_network(config, torch::kFloat32);
  const NetworkInput good = random_input(config, 1, 2, 4, 4, torch::kFloat32);
  NetworkInput bad = good;
  bad.features = good.features.narrow(2, 0, 6);
  try {
    network->forward(bad);
    FAIL() << "accepted 6 feature channels for 7";
  } catch (const Error& error) {
    EXPECT_STREQ(
        error.what(),
        "network: features has shape [1, 2, 6, 4, 4], expected [B, S, F, H, W] = [any, any, 7, any, any]");
  }
  bad = good;
  bad.radiance = good.radiance.narrow(4, 0, 3);
  EXPECT_THROW(network->forward(bad), Error);
  bad = good;
  bad.valid = good.valid.narrow(1, 0, 1);
  EXPECT_THROW(network->forward(bad), Error);
  bad = good;
  bad.valid = Tensor();
  EXPECT_THROW(network->forward(bad), Error);
  bad = {good.features.narrow(1, 0, 0), good.radiance.narrow(1, 0, 0), good.valid.narrow(1, 0, 0)};
  EXPECT_THROW(network->forward(bad), Error);
  EXPECT_THROW(network->forward(to_type(good, torch::kFloat64)), std::exception);
}

}  // namespace
}  // namespace ld
