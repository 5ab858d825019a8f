#include "benchmark/workloads.h"
#include "frame/schema.h"
#include "models/graphs/network_cost.h"
#include "models/sample_partitioner.h"
#include "models/sample_reducer.h"
#include "ops/kernel_gather.h"
#include "ops/kernel_splat.h"
#include "ops/partition.h"

namespace ld {
namespace {

using torch::Tensor;
using torch::autograd::variable_list;

/// A call of an operator: its results, and the tensors whose gradients a training step asks for.
struct Call {
  std::function<variable_list()> results;
  variable_list differentiable;
  double multiply_adds;        // of the forward pass
  double input_gradient_less;  // of the backward pass, where the input has no gradient
};

Workload workload(const Call& call, bool train) {
  if (!train)
    return {[call] {
              const c10::InferenceMode no_graph;
              call.results();
            },
            call.multiply_adds};
  variable_list gradients;
  {
    const torch::NoGradGuard no_graph;
    for (const Tensor& result : call.results()) gradients.push_back(torch::rand_like(result));
  }
  const auto run = [call, gradients] {
    torch::autograd::grad(call.results(), call.differentiable, gradients);
  };
  return {run, 3 * call.multiply_adds - call.input_gradient_less};
}

/// The weights of a fully connected network, filled with numbers that keep activations of order 1.
void fill(torch::nn::Module& module) {
  const torch::NoGradGuard no_graph;
  for (Tensor& parameter : module.parameters()) parameter.normal_(0, 0.15);
}

Tensor leaf(const Tensor& values) {
  return values.detach().set_requires_grad(true);
}

struct Sizes {
  NetworkConfig config;
  int64_t spp, side;
  double pixels() const { return double(side * side); }
  NetworkCost cost() const { return multiply_adds(config, spp, side, side); }
  int64_t taps() const { return config.kernel_size * config.kernel_size; }
};

Call reducer(const Sizes& sizes) {
  const auto module = std::make_shared<SampleReducer>(sizes.config, channel_count(sizes.config.features));
  fill(*module);
  const Tensor features = bench_input(sizes.config, sizes.spp, sizes.side).features;
  const NetworkCost cost = sizes.cost();
  return {[module, features] { return variable_list{module->forward(features)}; }, module->parameters(),
          cost.reducer, cost.first_layer};
}

/// The partitioner network and the splat of the samples to layers, as the layer network has them.
Call partition_to_layers(const Sizes& sizes) {
  const auto module = std::make_shared<SamplePartitioner>(sizes.config);
  fill(*module);
  const NetworkInput input = bench_input(sizes.config, sizes.spp, sizes.side);
  const int64_t channels = sizes.config.sample_reducer.back();
  const Tensor embedding = leaf(torch::randn({1, sizes.spp, channels, sizes.side, sizes.side}));
  const Tensor context = leaf(torch::randn({1, sizes.config.unet.context, sizes.side, sizes.side}));
  variable_list differentiable = module->parameters();
  differentiable.push_back(embedding);
  differentiable.push_back(context);
  const auto results = [=] {
    const Partition layers =
        partition(module->forward(embedding, context), input.valid, input.radiance, embedding);
    return variable_list{layers.log_n, layers.radiance, layers.transmittance, layers.embedding};
  };
  const double sums = double(sizes.spp * sizes.config.layers * (channels + 3 + 1)) * sizes.pixels();
  return {results, differentiable, sizes.cost().partitioner + sums, 0};
}

Call splat(const Sizes& sizes) {
  const int64_t layers = sizes.config.layers;
  const Tensor logits = leaf(torch::randn({1, layers, sizes.taps(), sizes.side, sizes.side}));
  const Tensor log_n = leaf(torch::rand({1, layers, sizes.side, sizes.side}).log());
  const Tensor values = leaf(torch::rand({1, layers, 4, sizes.side, sizes.side}));
  return {[=] { return variable_list{kernel_splat(logits, log_n, values)}; },
          {logits, log_n, values},
          double(layers * sizes.taps() * (4 + 1)) * sizes.pixels(),
          0};
}

Call gather(const Sizes& sizes) {
  const Tensor logits = leaf(torch::randn({1, sizes.taps(), sizes.side, sizes.side}));
  const Tensor log_n = torch::zeros({1, sizes.side, sizes.side});
  const Tensor values = torch::rand({1, 3, sizes.side, sizes.side});
  const double cost = double(sizes.taps() * (3 + 1)) * sizes.pixels();
  return {[=] { return variable_list{kernel_gather(logits, log_n, values)}; }, {logits}, cost, cost};
}

}  // namespace

std::vector<RowSpec> operator_rows(const BenchSizes& sizes) {
  const std::vector<std::pair<std::string, Call (*)(const Sizes&)>> operators = {
      {"reducer", reducer}, {"partition", partition_to_layers}, {"splat17", splat}, {"gather17", gather}};
  std::vector<RowSpec> rows;
  for (const auto& [name, make] : operators)
    for (const bool train : {false, true})
      rows.push_back(
          {name + (train ? "_train" : "_forward"), [sizes, make = make, train] {
             torch::manual_seed(1);
             return workload(make({bench_config(sizes, "layer"), sizes.spp, sizes.inference}), train);
           }});
  return rows;
}

}  // namespace ld
