// Networks that read means: samples and the picture of their mean are one input.
#include "models/pixel_mean.h"

#include <gtest/gtest.h>

#include "ops/tone_map_tensor.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {

using torch::Tensor;

std::vector<NetworkConfig> means_configs() {
  std::vector<NetworkConfig> configs;
  for (NetworkConfig config : every_config()) {
    if (!works_on_pixels(config)) continue;
    config.means = true;
    configs.push_back(config);
    if (!may_be_exposed(config)) continue;
    config.exposure_normalisation = true;
    configs.push_back(config);
  }
  return configs;
}

/// What a renderer would write of it: the mean of the samples that there are, no sample where there is none.
NetworkInput picture_of(const NetworkInput& input) {
  const Tensor weight = input.valid / input.valid.sum(1, true).clamp_min(1);
  NetworkInput picture = {(input.features * weight).sum(1, true), (input.radiance * weight).sum(1, true),
                          input.valid.amax(1, true)};
  picture.features.narrow(2, 0, 3).copy_(tone_map(picture.radiance) *
                                         picture.valid);  // features begin with radiance
  return picture;
}

TEST(PixelMean, SamplesAndThePictureOfTheirMeanAreDenoisedAlike) {
  for (const NetworkConfig& config : means_configs()) {
    const std::shared_ptr<Network> network = small_network(config, torch::kFloat64);
    const NetworkInput input = random_input(config, 2, 5, 9, 7, torch::kFloat64);
    const torch::InferenceMode no_graph;
    const Tensor of_samples = network->forward(input), of_picture = network->forward(picture_of(input));
    EXPECT_LT((of_samples - of_picture).abs().max().item<double>(), 1e-9) << title(config);
    EXPECT_GT(of_samples.abs().max().item<double>(), 0);
  }
}

TEST(PixelMean, ExtremesStayFinite) {
  for (const NetworkConfig& config : means_configs()) {
    const std::shared_ptr<Network> network = small_network(config, torch::kFloat32);
    for (const float value :
         {0.0F, 1e-42F, 1e-38F, 65504.0F, 3e38F, -1.0F, std::numeric_limits<float>::infinity(),
          std::numeric_limits<float>::quiet_NaN()})
      for (const int64_t side : {1, 3}) {
        NetworkInput input = random_input(config, 1, 2, side, side, torch::kFloat32);
        input.radiance.fill_(value);
        const torch::InferenceMode no_graph;
        EXPECT_TRUE(network->forward(input).isfinite().all().item<bool>()) << title(config) << ", " << value;
      }
  }
}

TEST(PixelMean, NetworksOnSamplesRefuseIt) {
  NetworkConfig config = small_config();
  config.means = true;
  EXPECT_ERROR(make_network(config), "network 'layer' works on samples");
}

}  // namespace
}  // namespace ld
