#include "tuning/cost.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <set>

#include "core/error.h"
#include "core/process/process_memory.h"
#include "core/random.h"
#include "export/activation_ranges.h"
#include "export/quantised_export.h"
#include "models/graphs/network_graph.h"
#include "runtime/executor.h"

namespace ld {
namespace {

Frame noise_frame(const std::vector<std::string>& features, const PictureExtent& picture) {
  const double megabytes =
      4e-6 * double(kSampleChannels * picture.samples) * double(picture.height) * double(picture.width);
  if (const int64_t there = available_bytes(); there >= 0 && 1e6 * megabytes > double(there))
    fail(
        "a frame of {}x{} at {} samples a pixel takes {:.0f} MB, and the machine has {:.0f}; give a smaller "
        "--at or --samples",
        picture.width, picture.height, picture.samples, megabytes, 1e-6 * double(there));
  Frame frame(int(picture.width), int(picture.height), int(picture.samples));
  frame.features = features;
  frame.info.depth_scale = 0.5F;
  RandomStream random(1, RandomPurpose::test);
  std::vector<float> row(size_t(picture.width) + 4096);  // each row begins elsewhere in it
  for (float& value : row) value = random.uniform();
  for (const std::string& name : features) {
    const Feature& feature = find_feature(name);
    for (int s = 0; s < frame.spp; ++s)
      for (int c = 0; c < feature.channels; ++c)
        for (int y = 0; y < frame.height; ++y)
          std::copy_n(row.data() + random.below(4096), frame.width,
                      frame.plane(s, feature.offset + c) + size_t(y) * size_t(frame.width));
  }
  return frame;
}

/// What a node's time is in proportion to.
double work_of(const graph::Graph& graph, const graph::Node& node, const PictureExtent& picture) {
  const graph::NodeCost cost = graph::cost_of(graph, node, picture);
  if (cost.weights + cost.taps > 0) return cost.weights + cost.taps;
  double numbers = 0;
  for (const graph::ValueId output : node.outputs) {
    const graph::ValueExtent extent = graph::extent_of(graph, output, picture);
    numbers += double(extent.planes) * double(extent.height) * double(extent.width);
  }
  return numbers;
}

double run_ms(Execution& execution, const Frame& frame) {
  const auto start = std::chrono::steady_clock::now();
  execution.run(frame);
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

}  // namespace

NetworkWeights random_weights(const NetworkConfig& config) {
  NetworkWeights network{config, network_graph(config), {}};
  RandomStream random(1, RandomPurpose::initial_weights);
  for (const graph::Parameter& parameter : graph::parameters(network.graph)) {
    NamedWeight weight{parameter.shape, std::vector<float>(size_t(graph::count_of(parameter)))};
    const double fan_in = double(weight.values.size()) / double(parameter.shape[0]);
    const auto bound = float(parameter.shape.size() > 1 ? std::sqrt(3 / fan_in) : 0);
    for (float& value : weight.values) value = random.uniform(-bound, bound);
    network.weights.add(parameter.name, std::move(weight));
  }
  return network;
}

NetworkWeights random_weights_in_eight_bits(const NetworkConfig& config) {
  const NetworkWeights network = random_weights(config);
  ActivationRanges ranges(network);
  ranges.add(noise_frame(config.features, {2, 16, 16}), 1);
  return quantised(network, ranges);
}

std::vector<NetworkTime> measure_networks(const std::vector<NetworkWeights>& networks,
                                          const PictureExtent& picture, int threads) {
  constexpr double kEnough = 500;  // ms
  std::set<std::string> features;
  for (const NetworkWeights& network : networks)
    features.insert(network.config.features.begin(), network.config.features.end());
  const Frame frame = noise_frame({features.begin(), features.end()}, picture);
  std::vector<std::unique_ptr<Execution>> executions;
  double slowest = 0;
  for (const NetworkWeights& network : networks) {
    executions.push_back(
        std::make_unique<Execution>(network.graph, network.weights, picture, ExecutionOptions{threads}));
    slowest = std::max(slowest, run_ms(*executions.back(), frame));  // in which memory is new
  }
  const auto repeats = size_t(std::ceil(std::clamp(kEnough / slowest, 3.0, 15.0)));
  std::vector<std::vector<double>> times(networks.size());
  for (size_t round = 0; round < repeats; ++round)
    for (size_t n = 0; n < networks.size(); ++n) times[n].push_back(run_ms(*executions[n], frame));
  std::vector<NetworkTime> found;
  for (size_t n = 0; n < networks.size(); ++n) {
    const auto middle = times[n].begin() + int64_t(repeats / 2);
    std::nth_element(times[n].begin(), middle, times[n].end());
    found.push_back({*middle, 1e-6 * double(executions[n]->memory_bytes())});
  }
  return found;
}

NetworkTime measure_network(const NetworkWeights& network, const PictureExtent& picture, int threads) {
  return measure_networks({network}, picture, threads).front();
}

CostModel::CostModel(const std::vector<NetworkConfig>& calibration, const PictureExtent& picture,
                     int threads) {
  std::map<size_t, double> work, seconds;
  for (const NetworkConfig& config : calibration) {
    const NetworkWeights network = random_weights(config);
    const Frame frame = noise_frame(config.features, picture);
    Execution execution(network.graph, network.weights, picture, {threads});
    execution.run(frame);
    execution.run(frame);
    for (size_t n = 0; n < network.graph.nodes.size(); ++n) {
      const graph::Node& node = network.graph.nodes[n];
      work[node.op.index()] += work_of(network.graph, node, picture);
      seconds[node.op.index()] += execution.seconds()[n];
    }
  }
  for (const auto& [op, amount] : work) seconds_[op] = seconds[op] / std::max(amount, 1.0);
}

double CostModel::milliseconds(const NetworkConfig& config, const PictureExtent& picture) const {
  const graph::Graph graph = network_graph(config);
  double dearest = 0, sum = 0;
  for (const auto& [op, seconds] : seconds_) dearest = std::max(dearest, seconds);
  for (const graph::Node& node : graph.nodes) {
    const auto found = seconds_.find(node.op.index());
    sum += work_of(graph, node, picture) * (found == seconds_.end() ? dearest : found->second);
  }
  return 1e3 * sum;
}

}  // namespace ld
