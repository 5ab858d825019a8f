#include "benchmark/planned_network.h"
#include "benchmark/workloads.h"
#include "frame/schema.h"
#include "losses/loss.h"
#include "models/graphs/network_cost.h"
#include "models/initialise.h"
#include "training/run/config_file.h"

namespace ld {

using torch::Tensor;

NetworkConfig read_network_config(const std::string& file) {
  return read_train_config(file).network;
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
  const auto planned =
      std::make_shared<PlannedNetwork>(bench_weights(config), PictureExtent{spp, side, side});
  const auto composition = [network = bench_network(config), input = bench_input(config, spp, side)] {
    const c10::InferenceMode no_graph;
    network->forward(input);
  };
  return {[planned] { planned->run(); }, planned->multiply_adds(), Taps::at_once, composition,
          1e-6 * double(planned->execution().memory_bytes())};
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
  std::vector<RowSpec> rows;
  for (const std::string& name : network_names()) {
    rows.push_back({name + "_infer_256", [sizes, name] {
                      return inference_workload(bench_config(sizes, name), sizes.spp, sizes.inference);
                    }});
    if (network_traits(name).sources == Sources::layers)
      rows.push_back({name + "_train_128", [sizes, name] {
                        return training_workload(bench_config(sizes, name), sizes.spp, sizes.training);
                      }});
  }
  return rows;
}

}  // namespace ld
