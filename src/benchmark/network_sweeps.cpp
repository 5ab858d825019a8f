#include "benchmark/network_sweeps.h"

#include <algorithm>
#include <array>
#include <variant>

#include "benchmark/peak_memory.h"
#include "benchmark/planned_network.h"
#include "core/log.h"
#include "graph/extent.h"
#include "models/graphs/network_cost.h"
#include "models/graphs/network_graph.h"

namespace ld {
namespace {

constexpr int64_t kPublishedSpp = 8;

/// The part of a layered network that a node belongs to, by its place among kStages.
constexpr std::array<const char*, 4> kStages = {"reducer", "U-net", "partitioner", "layer filtering"};

struct StageOf {
  const graph::Graph& graph;
  const graph::Node& node;

  template <class Op>
  size_t operator()(const Op&) const {
    return 3;
  }
  size_t operator()(const graph::Encode&) const { return 0; }
  size_t operator()(const graph::MaskedMean&) const { return 1; }
  size_t operator()(const graph::Pad&) const { return 1; }
  size_t operator()(const graph::Convolution&) const { return 1; }
  size_t operator()(const graph::MaxPool&) const { return 1; }
  size_t operator()(const graph::Upsample&) const { return graph[node.outputs[0]].padded ? 1 : 3; }
  size_t operator()(const graph::Partition&) const { return 2; }
  size_t operator()(const graph::FullyConnected& op) const {
    return op.weights == "sample_reducer" ? 0 : op.weights == "sample_partitioner" ? 2 : 3;
  }
};

NetworkStages stages_of(const BenchSizes& sizes, const std::string& name, int repeats) {
  PlannedNetwork network(bench_weights(bench_config(sizes, name)),
                         {sizes.spp, sizes.inference, sizes.inference});
  network.run();
  std::array<std::vector<double>, kStages.size()> times;
  std::array<double, kStages.size()> cost = {};
  const graph::Graph& graph = network.graph();
  for (int i = 0; i < repeats; ++i) {
    network.run();
    for (auto& stage : times) stage.push_back(0);
    for (size_t n = 0; n < graph.nodes.size(); ++n)
      times[std::visit(StageOf{graph, graph.nodes[n]}, graph.nodes[n].op)].back() +=
          1e3 * network.execution().seconds()[n];
  }
  for (const graph::Node& node : graph.nodes) {
    const graph::NodeCost of_node = cost_of(graph, node, network.execution().picture());
    cost[std::visit(StageOf{graph, node}, node.op)] += of_node.weights + of_node.taps;
  }
  NetworkStages result{name, {}};
  const double pixels = double(sizes.inference * sizes.inference);
  for (size_t i = 0; i < kStages.size(); ++i)
    result.stages.push_back({kStages[i], median(times[i]), cost[i] / pixels});
  return result;
}

}  // namespace

std::vector<SampleTime> time_by_samples(const BenchSizes& sizes, const std::vector<int64_t>& spp,
                                        int repeats) {
  const NetworkConfig config = bench_config(sizes, "layer");
  const auto time = [&](int64_t count) {
    spdlog::info("layer network at {} samples a pixel ...", count);
    PlannedNetwork network(bench_weights(config), {count, sizes.inference, sizes.inference});
    return median_ms([&] { network.run(); }, repeats);
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
          {"inference_peak_mb", inference.held_mb + peak_memory_mb(inference.run)},
          {"training_ms", training_ms},
          {"training_peak_mb", peak_memory_mb(training.run)}};
}

}  // namespace ld
