#include <algorithm>
#include <filesystem>

#include "benchmark/cost.h"
#include "benchmark/workloads.h"
#include "frame/schema.h"
#include "losses/loss.h"
#include "training/config.h"

namespace ld {

using torch::Tensor;

NetworkConfig bench_config(const BenchSizes& sizes, const std::string& network) {
  std::string file = network;
  if (sizes.quick) file = network == "layer" ? "quick" : "quick_" + network;
  return config_from_tree<TrainConfig>(read_config(std::filesystem::path(sizes.configs) / (file + ".yaml")))
      .network;
}

NetworkInput bench_input(const NetworkConfig& config, int64_t spp, int64_t side) {
  return {2 * torch::rand({1, spp, channel_count(config.features), side, side}) - 1,
          torch::rand({1, spp, 3, side, side}), torch::ones({1, spp, 1, side, side})};
}

std::shared_ptr<Network> bench_network(const BenchSizes& sizes, const std::string& name) {
  auto network = make_network(bench_config(sizes, name));
  initialise_xavier(*network, 1);
  return network;
}

Workload inference_workload(const BenchSizes& sizes, const std::string& name, int64_t spp) {
  torch::manual_seed(1);
  const auto network = bench_network(sizes, name);
  const NetworkInput input = bench_input(network->config(), spp, sizes.inference);
  const auto run = [network, input] {
    const c10::InferenceMode no_graph;
    network->forward(input);
  };
  return {run, multiply_adds(network->config(), spp, sizes.inference, sizes.inference).total()};
}

Workload training_workload(const BenchSizes& sizes, const std::string& name) {
  torch::manual_seed(1);
  const auto network = bench_network(sizes, name);
  const NetworkInput input = bench_input(network->config(), sizes.spp, sizes.training);
  const Tensor reference = torch::rand({1, 3, sizes.training, sizes.training});
  const auto run = [network, input, reference, loss = make_loss("smape")] {
    torch::autograd::grad({loss(network->forward(input), reference)}, network->parameters());
  };
  return {run, multiply_adds(network->config(), sizes.spp, sizes.training, sizes.training).training()};
}

std::vector<RowSpec> network_rows(const BenchSizes& sizes) {
  struct Entry {
    std::string row, network;
    bool train;
  };
  const std::vector<Entry> entries = {{"layer_infer_256", "layer", false},
                                      {"layer_train_128", "layer", true},
                                      {"optimized_infer_256", "optimized", false},
                                      {"optimized_train_128", "optimized", true},
                                      {"sample_splat_infer_256", "sample_splat", false},
                                      {"pixel_gather_infer_256", "pixel_gather", false}};
  const std::vector<std::string> known = network_names();
  std::vector<RowSpec> rows;
  for (const Entry& entry : entries) {
    if (std::find(known.begin(), known.end(), entry.network) == known.end()) continue;
    rows.push_back({entry.row, [sizes, entry] {
                      return entry.train ? training_workload(sizes, entry.network)
                                         : inference_workload(sizes, entry.network, sizes.spp);
                    }});
  }
  return rows;
}

}  // namespace ld
