// Networks and losses on another device than the CPU.
#include <gtest/gtest.h>

#include <limits>

#include "losses/loss.h"
#include "ops/composition.h"
#include "ops/warp.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"
#include "tests/support/fake_device.h"

namespace ld {
namespace {

using torch::Tensor;

/// Every network in every form that reads its input in a way of its own.
std::vector<NetworkConfig> every_form() {
  std::vector<NetworkConfig> configs;
  for (NetworkConfig& config : every_config()) {
    configs.push_back(config);
    config.exposure_normalisation = may_be_exposed(config);
    if (works_on_pixels(config)) config.means = true;
    configs.push_back(config);
  }
  return configs;
}

/// An input with faults, its radiance times `exposure`.
NetworkInput input_of(const NetworkConfig& config, double exposure) {
  NetworkInput input = random_input(config, 2, 3, 9, 11, torch::kFloat32);
  input.radiance = input.radiance * exposure;
  input.features.index_put_({0, 0, 0, 4, 4}, std::numeric_limits<float>::quiet_NaN());  // to be mended
  input.radiance.index_put_({0, 1, 0, 5, 5}, -1);
  return input;
}

/// What a network comes to: its picture, kernels and, of the mean of the picture, its gradients.
std::vector<Tensor> results(Network& network, const NetworkInput& input) {
  std::vector<Tensor> results;
  {
    const torch::NoGradGuard no_graph;
    results.push_back(network.forward(input));
  }
  results.push_back(network.forward(input));
  results[1].mean().backward();
  for (const Tensor& parameter : network.parameters())
    results.push_back(parameter.grad().defined() ? parameter.grad() : torch::zeros_like(parameter));
  const Kernels kernels = network.kernels(input);
  results.push_back(kernels.logits);
  results.push_back(kernels.log_n.exp());
  return results;
}

void expect_the_cpus(const std::vector<Tensor>& found, const std::vector<Tensor>& cpu) {
  ASSERT_EQ(found.size(), cpu.size());
  for (size_t i = 0; i < found.size(); ++i) {
    EXPECT_EQ(found[i].device(), fake_device()) << i;
    const double largest = cpu[i].abs().max().item<double>();
    EXPECT_LE(largest_difference(found[i].cpu(), cpu[i]), 1e-3 * largest) << i;
  }
}

TEST(Device, TheFakeOneIsNoCpu) {
  const Tensor here = torch::arange(6, fake_device()).to(torch::kFloat32).view({2, 3});
  EXPECT_EQ(here.device(), fake_device());
  EXPECT_TRUE((here * 2).cpu().equal(2 * torch::arange(6).to(torch::kFloat32).view({2, 3})));
  EXPECT_ANY_THROW(here + torch::ones({2, 3}));
  EXPECT_ANY_THROW(torch::cat({here, torch::ones({2, 3})}));
  EXPECT_DEATH(here.data_ptr<float>()[0] = 1, "");
}

TEST(Device, EveryNetworkAndLossTakesItsInputsDevice) {
  if (const std::string why = no_fake_gradients(); !why.empty()) GTEST_SKIP() << why;
  for (const NetworkConfig& config : every_form()) {
    SCOPED_TRACE(title(config) + (config.exposure_normalisation ? ", exposed" : ""));
    const auto cpu = small_network(config, torch::kFloat32), other = small_network(config, torch::kFloat32);
    other->to(fake_device());
    EXPECT_EQ(other->device(), fake_device());
    expect_the_cpus(results(*other, input_of(config, 1)), results(*cpu, input_of(config, 1)));
    // What is filtered scaled down has gradients that differ from those of the kernels.
    cpu->zero_grad();
    other->zero_grad();
    const ComposedOperators composed;
    expect_the_cpus(results(*other, input_of(config, 1e36)), results(*cpu, input_of(config, 1e36)));
  }
  const Tensor denoised = random_normal({2, 3, 9, 11}, 1).to(torch::kFloat32),
               reference = random_uniform({2, 3, 9, 11}, 2, 0, 8).to(torch::kFloat32);
  for (const std::string& name : loss_names()) {
    SCOPED_TRACE(name);
    const auto value_and_gradient = [&](const torch::Device& device) -> std::vector<Tensor> {
      const Tensor at_device = denoised.to(device).detach().requires_grad_();
      const Tensor value = make_loss(name)(at_device, reference);
      value.backward();
      return {value.detach(), at_device.grad()};
    };
    expect_the_cpus(value_and_gradient(fake_device()), value_and_gradient(torch::kCPU));
  }
}

TEST(Device, WhatRunsOnTheCpuAloneSaysSo) {
  const Tensor values = torch::ones({1, 3, 4, 4}), flow = torch::zeros({1, 2, 4, 4}),
               valid = torch::ones({1, 1, 4, 4});
  EXPECT_ERROR(warp(values.to(fake_device()), flow, valid), "expected the CPU");
  EXPECT_ERROR(warp(values, flow.to(fake_device()), valid), "xpu");
}

}  // namespace
}  // namespace ld
