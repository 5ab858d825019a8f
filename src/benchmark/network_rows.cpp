#include <algorithm>

#include "benchmark/workloads.h"
#include "frame/schema.h"
#include "losses/loss.h"
#include "models/initialise.h"
#include "models/network_cost.h"
#include "training/run/config.h"

namespace ld {

using torch::Tensor;

NetworkConfig read_network_config(const std::string& file) {
  return config_from_tree<TrainConfig>(read_config(file)).network;
}

NetworkConfig bench_config(const BenchSizes& sizes, const std::string& network) {
  std::string file = network;
  if (sizes.quick) file = network == "layer" ? "quick" : "quick_" + network;
  return read_network_config(sizes.configs + "/" + file + ".yaml");
}

NetworkInput bench_input(const NetworkConfig& config, int64_t spp, int64_t side) {
  return {2 * torch::rand({1, spp, channel_count(config.features), side, side}) - 1,
          torch::rand({1, spp, 3, side, side}), torch::ones({1, spp, 1, side, side})};
}

std::shared_ptr<Network> bench_network(const NetworkConfig& config) {
  auto network = make_network(config);
  initialise(*network, 1);
  return network;
}

Workload inference_workload(const NetworkConfig& config, int64_t spp, int64_t side) {
  torch::manual_seed(1);
  const auto network = bench_network(config);
  const NetworkInput input = bench_input(config, spp, side);
  const auto run = [network, input] {
    const c10::InferenceMode no_graph;
    network->forward(input);
  };
  return {run, multiply_adds(config, spp, side, side).total()};
}

Workload training_workload(const NetworkConfig& config, int64_t spp, int64_t side) {
  torch::manual_seed(1);
  const auto network = bench_network(config);
  const NetworkInput input = bench_input(config, spp, side);
  const Tensor reference = torch::rand({1, 3, side, side});
  const auto run = [network, input, reference, loss = make_loss("smape")] {
    torch::autograd::grad({loss(network->forward(input), reference)}, network->parameters());
  };
  return {run, multiply_adds(config, spp, side, side).training(), Taps::sliced};
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
                      const NetworkConfig config = bench_config(sizes, entry.network);
                      return entry.train ? training_workload(config, sizes.spp, sizes.training)
                                         : inference_workload(config, sizes.spp, sizes.inference);
                    }});
  }
  return rows;
}

}  // namespace ld
