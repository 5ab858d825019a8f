#include "benchmark/network_sweeps.h"

#include <fmt/format.h>

#include <algorithm>

#include "benchmark/peak_memory.h"
#include "core/error.h"
#include "core/log.h"
#include "core/text_table.h"
#include "graph/extent.h"
#include "models/graphs/network_cost.h"
#include "models/graphs/network_graph.h"
#include "models/sample_partitioner.h"
#include "models/sample_reducer.h"
#include "models/unet.h"
#include "ops/partition.h"
#include "ops/weighted_sum.h"

namespace ld {
namespace {

using torch::Tensor;

constexpr int64_t kPublishedSpp = 8;

/// The module of the network that has this name.
template <class Module>
Module& child(Network& network, const char* name) {
  const auto found = std::dynamic_pointer_cast<Module>(network.named_children()[name]);
  if (!found) fail("stages of network {}: its module '{}' is of another kind", network.config().name, name);
  return *found;
}

NetworkStages stages_of(const BenchSizes& sizes, const std::string& name, int repeats) {
  const auto network = bench_network(bench_config(sizes, name));
  const NetworkConfig& config = network->config();
  const NetworkInput input = bench_input(config, sizes.spp, sizes.inference);
  auto& reducer = child<SampleReducer>(*network, "sample_reducer");
  auto& unet = child<UNet>(*network, "unet");
  auto& partitioner = child<SamplePartitioner>(*network, "sample_partitioner");
  const c10::InferenceMode no_graph;

  std::vector<double> reducing, context_making, partitioning, all;
  for (int i = 0; i <= repeats; ++i) {  // the first is the warm-up
    Tensor embedding, context;
    const double reducer_ms = time_ms([&] { embedding = reducer.forward(input.features); });
    const double unet_ms = time_ms([&] { context = unet.forward(masked_mean(embedding, input.valid)); });
    const double partition_ms = time_ms([&] {
      partition(partitioner.forward(embedding, context), input.valid, input.radiance, embedding,
                config.compositing == "alpha" ? Compositing::alpha : Compositing::weighted);
    });
    embedding.reset();
    const double all_ms = time_ms([&] { network->forward(input); });
    if (i == 0) continue;
    reducing.push_back(reducer_ms);
    context_making.push_back(unet_ms);
    partitioning.push_back(partition_ms);
    all.push_back(all_ms);
  }
  const NetworkCost cost = multiply_adds(config, sizes.spp, sizes.inference, sizes.inference);
  const double pixels = double(sizes.inference * sizes.inference);
  NetworkStages result{name,
                       {{"reducer", median(reducing), cost.reducer / pixels},
                        {"U-net", median(context_making), cost.unet / pixels},
                        {"partitioner", median(partitioning), cost.partitioner / pixels}}};
  double rest = median(all);
  for (const StageTime& stage : result.stages) rest -= stage.ms;
  result.stages.push_back(
      {"layer filtering", std::max(rest, 0.0), (cost.kernel_generator + cost.filtering) / pixels});
  return result;
}

}  // namespace

std::vector<SampleTime> time_by_samples(const BenchSizes& sizes, const std::vector<int64_t>& spp,
                                        int repeats) {
  const NetworkConfig config = bench_config(sizes, "layer");
  const auto time = [&](int64_t count) {
    spdlog::info("layer network at {} samples a pixel ...", count);
    return median_ms(inference_workload(config, count, sizes.inference).run, repeats);
  };
  std::vector<SampleTime> times;
  for (const int64_t count : spp) times.push_back({count, time(count), 0});
  const auto published = std::find(spp.begin(), spp.end(), kPublishedSpp);
  const double reference_ms =
      published == spp.end() ? time(kPublishedSpp) : times[size_t(published - spp.begin())].ms;
  for (SampleTime& entry : times) entry.ratio = entry.ms / reference_ms;
  return times;
}

std::vector<NetworkCosts> cost_by_samples(const BenchSizes& sizes, const std::vector<int64_t>& spp) {
  std::vector<NetworkCosts> costs;
  const int64_t side = sizes.inference;
  for (const std::string& name : network_names()) {
    const NetworkConfig config = bench_config(sizes, name);
    costs.push_back({name, {}});
    for (const int64_t count : spp)
      costs.back().per_pixel.push_back(multiply_adds(config, count, side, side).total() /
                                       double(side * side));
  }
  return costs;
}

std::vector<NetworkStages> time_by_stage(const BenchSizes& sizes, int repeats) {
  std::vector<NetworkStages> all;
  for (const std::string& name : network_names())
    if (network_traits(name).sources == Sources::layers) all.push_back(stages_of(sizes, name, repeats));
  return all;
}

nlohmann::ordered_json measure_network(const std::string& file, const BenchSizes& sizes, int repeats) {
  const NetworkConfig config = read_network_config(file);
  const Workload inference = inference_workload(config, sizes.spp, sizes.inference),
                 training = training_workload(config, sizes.spp, sizes.training);
  const double inference_ms = median_ms(inference.run, repeats),
               training_ms = median_ms(training.run, repeats);
  return {{"config", file},
          {"parameters", graph::parameter_count(network_graph(config))},
          {"multiply_adds_per_pixel", inference.multiply_adds / double(sizes.inference * sizes.inference)},
          {"inference_ms", inference_ms},
          {"inference_peak_mb", peak_memory_mb(inference.run)},
          {"training_ms", training_ms},
          {"training_peak_mb", peak_memory_mb(training.run)}};
}

}  // namespace ld
