#include "training/fine_tuning.h"

#include <fmt/ranges.h>

#include <algorithm>

#include "core/log.h"
#include "models/initialise.h"
#include "training/device.h"
#include "weights/mix_weights.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

/// The names that `others` lacks, as a list for a message.
std::string missing_from(const std::vector<std::string>& others, const std::vector<std::string>& names) {
  std::vector<std::string> missing;
  for (const std::string& name : names)
    if (std::find(others.begin(), others.end(), name) == others.end()) missing.push_back(name);
  return missing.empty() ? "none" : fmt::format("{}", fmt::join(missing, ", "));
}

}  // namespace

void begin_with_weights(const std::filesystem::path& model, Network& network) {
  mix_in_weights(model, 1, network, "init");
  const std::vector<std::string> from = read_weights_header(SafetensorsFile(resolve_model(model)))
                                            .network.features,
                                 &to = network.config().features;
  spdlog::info("beginning with the weights of {}", model.string());
  if (from != to)
    spdlog::info("features that it had and this run has not: {}; new features, which begin at 0: {}",
                 missing_from(to, from), missing_from(from, to));
}

std::shared_ptr<Network> make_initial_network(const TrainConfig& config, bool with_init) {
  std::shared_ptr<Network> network = make_network(config.network);
  initialise(*network, config.seed);
  if (with_init && !config.init.empty()) begin_with_weights(config.init, *network);
  network->to(device_named(config.run.device));
  return network;
}

}  // namespace ld
