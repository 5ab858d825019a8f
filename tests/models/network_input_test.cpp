// What enters a network: wrong shapes, bad samples, extreme numbers.
#include "models/network_input.h"

#include <gtest/gtest.h>

#include <limits>
#include <optional>

#include "losses/loss.h"
#include "ops/composition.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {

using torch::Tensor;

const double kNan = std::numeric_limits<double>::quiet_NaN();
const double kInfinity = std::numeric_limits<double>::infinity();

/// All samples drawn, so that the tests know what they remove.
NetworkInput full_input(const NetworkConfig& config, int64_t samples, int64_t h, int64_t w) {
  NetworkInput input = random_input(config, 1, samples, h, w, torch::kFloat32);
  input.valid.fill_(1);
  input.features = random_normal(input.features.sizes(), 5).to(torch::kFloat32);
  input.radiance = random_uniform(input.radiance.sizes(), 6, 0, 4).to(torch::kFloat32);
  return input;
}

/// Products of matrices with another number of rows may round otherwise in the last bit.
void expect_same_but_for_rounding(const Tensor& found, const Tensor& expected, const std::string& where) {
  EXPECT_TRUE(found.allclose(expected, /*rtol=*/1e-5, /*atol=*/1e-6))
      << where << ", off by " << (found - expected).abs().max();
}

TEST(NetworkInput, AMaskedSampleIsLikeOneThatWasRemoved) {
  for (const NetworkConfig& config : every_network()) {
    const auto network = small_network(config, torch::kFloat32);
    NetworkInput input = random_input(config, 1, 4, 6, 7, torch::kFloat32);
    input.features = random_normal(input.features.sizes(), 5).to(torch::kFloat32);
    input.valid.select(1, 2).zero_();  // its features and radiance keep their values: the mask alone must do
    expect_same_but_for_rounding(network->forward(input), network->forward(select_samples(input, {0, 1, 3})),
                                 title(config));
  }
}

TEST(NetworkInput, ABadSampleIsLikeOneThatWasRemoved) {
  for (const NetworkConfig& config : every_network()) {
    const auto network = small_network(config, torch::kFloat32);
    for (const double bad : {kNan, kInfinity, -kInfinity})
      for (const bool in_features : {true, false}) {
        NetworkInput input = full_input(config, 4, 6, 7);
        const Tensor expected = network->forward(select_samples(input, {0, 2, 3}));
        EXPECT_EQ(network->faults().not_finite, 0);
        Tensor& channels = in_features ? input.features : input.radiance;
        channels.select(1, 1).select(1, 2).fill_(bad);  // one channel of every pixel's sample 1
        expect_same_but_for_rounding(
            network->forward(input), expected,
            title(config) + " " + std::to_string(bad) + (in_features ? " in features" : " in radiance"));
        EXPECT_EQ(network->faults().not_finite, 6 * 7);
        EXPECT_EQ(network->faults().negative, 0);
        EXPECT_EQ(network->faults().clamped, 0);
      }
  }
}

// In one pixel only: the same as masking it there.
TEST(NetworkInput, ABadSampleIsMaskedInItsPixelAlone) {
  for (const NetworkConfig& config : every_network()) {
    const auto network = small_network(config, torch::kFloat32);
    NetworkInput input = full_input(config, 3, 5, 6), masked = input;
    masked.valid = input.valid.clone();
    masked.valid.index_put_({0, 1, 0, 3, 2}, 0);
    input.features = input.features.clone();
    input.features.index_put_({0, 1, 4, 3, 2}, kNan);
    EXPECT_TRUE(network->forward(input).equal(network->forward(masked))) << title(config);
    EXPECT_EQ(network->faults().not_finite, 0);
    EXPECT_EQ(masked.valid.sum().item<int64_t>(), 3 * 5 * 6 - 1);
  }
}

TEST(NetworkInput, NegativeRadianceCountsAsZeroAndLargeFeaturesAsTheLargest) {
  const NetworkConfig config = small_config();
  NetworkInput input = full_input(config, 2, 3, 4), expected = input;
  expected.radiance = input.radiance.clone();
  expected.features = input.features.clone();
  expected.radiance.index_put_({0, 1, 2, 1, 1}, 0);
  expected.features.index_put_({0, 0, 3, 2, 2}, 65504);
  expected.features.index_put_({0, 0, 4, 2, 2}, -65504);
  input.radiance.index_put_({0, 1, 2, 1, 1}, -100);
  input.features.index_put_({0, 0, 3, 2, 2}, 3e38);
  input.features.index_put_({0, 0, 4, 2, 2}, -70000);
  InputFaults faults;
  const NetworkInput found = sanitise(input, faults);
  EXPECT_TRUE(found.radiance.equal(expected.radiance));
  EXPECT_TRUE(found.features.equal(expected.features));
  EXPECT_TRUE(found.valid.equal(expected.valid));
  EXPECT_EQ(faults.not_finite, 0);
  EXPECT_EQ(faults.negative, 1);
  EXPECT_EQ(faults.clamped, 2);
}

TEST(NetworkInput, SamplesThatWereNotDrawnAreNotCountedAndMayHoldAnything) {
  for (const NetworkConfig& config : every_network()) {
    const auto network = small_network(config, torch::kFloat32);
    NetworkInput input = full_input(config, 3, 4, 5);
    input.valid.select(1, 1).zero_();
    const Tensor expected = network->forward(input);
    for (const double bad : {kNan, -100.0, 3e38}) {
      input.features.select(1, 1).fill_(bad);
      input.radiance.select(1, 1).fill_(bad);
      EXPECT_TRUE(network->forward(input).equal(expected)) << title(config) << " " << bad;
      EXPECT_EQ(network->faults().not_finite + network->faults().negative + network->faults().clamped, 0);
    }
  }
}

TEST(NetworkInput, GoodInputIsNotCopied) {
  const NetworkInput input = full_input(small_config(), 2, 3, 4);
  InputFaults faults;
  const NetworkInput found = sanitise(input, faults);
  EXPECT_EQ(found.features.data_ptr(), input.features.data_ptr());
  EXPECT_EQ(found.radiance.data_ptr(), input.radiance.data_ptr());
}

void expect_finite(const NetworkConfig& config, double extreme, const std::string& loss) {
  const auto network = small_network(config, torch::kFloat32);
  NetworkInput input = random_input(config, 1, 3, 5, 6, torch::kFloat32);
  const Tensor where = random_uniform({1, 3, 1, 5, 6}, 8).gt(0.7).logical_and(input.valid.ne(0));
  input.radiance = input.radiance.masked_fill(where, extreme);
  input.features = input.features.masked_fill(where, -extreme);
  const Tensor output = network->forward(input);
  make_loss(loss)(output, torch::ones_like(output)).backward();
  EXPECT_TRUE(all_finite(output)) << title(config) << " " << extreme;
  for (const auto& entry : network->named_parameters())
    EXPECT_TRUE(all_finite(entry.value().grad()))
        << title(config) << " " << loss << " " << extreme << " " << entry.key();
}

TEST(NetworkInput, ExtremesStayFinite) {
  for (const bool compose : {false, true}) {
    std::optional<ComposedOperators> composed;  // whose sums are not bounded by the operators themselves
    if (compose) composed.emplace();
    for (const NetworkConfig& config : every_network())
      for (const double extreme :
           {0.0, 1e-40, 1e-38, 65504.0, 1e30, 3e38, -100.0, kNan, kInfinity, -kInfinity})
        for (const std::string& loss : loss_names()) expect_finite(config, extreme, loss);
  }
}

TEST(NetworkInput, BadShapesAreErrors) {
  for (const NetworkConfig& config : every_network()) {
    const auto network = small_network(config, torch::kFloat32);
    const NetworkInput good = random_input(config, 1, 2, 4, 4, torch::kFloat32);
    NetworkInput bad = good;
    bad.features = good.features.narrow(2, 0, 6);
    EXPECT_ERROR(network->forward(bad), fmt::format("network: features has shape [1, 2, 6, 4, 4], expected "
                                                    "[B, S, F, H, W] = [any, any, {}, any, any]",
                                                    channel_count(config.features)));
    bad = good;
    bad.radiance = good.radiance.narrow(4, 0, 3);
    EXPECT_ERROR(network->forward(bad), "network: radiance has shape [1, 2, 3, 4, 3]");
    bad = good;
    bad.valid = good.valid.narrow(1, 0, 1);
    EXPECT_ERROR(network->forward(bad), "network: valid has shape [1, 1, 1, 4, 4]");
    bad = good;
    bad.valid = Tensor();
    EXPECT_ERROR(network->forward(bad), "network: valid");
    EXPECT_ERROR(network->forward(select_samples(good, {})), "0 samples a pixel");
    bad = {good.features.narrow(3, 0, 0), good.radiance.narrow(3, 0, 0), good.valid.narrow(3, 0, 0)};
    EXPECT_ERROR(network->forward(bad), "features are empty");
    bad = good;
    bad.radiance = good.radiance.to(torch::kFloat64);
    EXPECT_ERROR(network->forward(bad), "network: radiance has element type Double, expected Float");
  }
}

}  // namespace
}  // namespace ld
