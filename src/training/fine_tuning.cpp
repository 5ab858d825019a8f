#include "training/fine_tuning.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>

#include "core/error.h"
#include "core/log.h"
#include "frame/schema.h"
#include "models/initialise.h"
#include "training/device.h"
#include "weights/model_file.h"

namespace ld {
namespace {

/// The one parameter whose columns are the features.
constexpr const char* kFirstLayer = "sample_reducer.0.weight";
/// Parameters that weights may lack: as they begin, they change nothing of a frame (models/rejection.h,
/// models/history.h).
bool may_be_missing(const std::string& parameter) {
  return parameter.rfind("rejection.", 0) == 0 || parameter.rfind("history.", 0) == 0;
}

/// First channel of each feature among the network's inputs.
std::map<std::string, int64_t> first_channels(const std::vector<std::string>& features) {
  std::map<std::string, int64_t> first;
  int64_t channel = 0;
  for (const std::string& name : features) {
    first[name] = channel;
    channel += find_feature(name).channels;
  }
  return first;
}

/// stored [outputs, blocks * channels of `from`] -> [outputs, blocks * channels of `to`]. A block is what the
/// reducer reads of each channel: the value, or mean and variance.
torch::Tensor with_features(const torch::Tensor& stored, const std::vector<std::string>& from,
                            const std::vector<std::string>& to) {
  const int64_t old_channels = channel_count(from), new_channels = channel_count(to);
  const int64_t blocks = stored.size(1) / old_channels;
  const auto source = first_channels(from);
  torch::Tensor columns = torch::zeros({stored.size(0), blocks * new_channels}, stored.options());
  for (const auto& [name, first] : first_channels(to)) {
    const auto found = source.find(name);
    if (found == source.end()) continue;
    const int64_t count = find_feature(name).channels;
    for (int64_t block = 0; block < blocks; ++block)
      columns.narrow(1, block * new_channels + first, count)
          .copy_(stored.narrow(1, block * old_channels + found->second, count));
  }
  return columns;
}

/// The names that `others` lacks, as a list for a message.
std::string missing_from(const std::vector<std::string>& others, const std::vector<std::string>& names) {
  std::vector<std::string> missing;
  for (const std::string& name : names)
    if (std::find(others.begin(), others.end(), name) == others.end()) missing.push_back(name);
  return missing.empty() ? "none" : fmt::format("{}", fmt::join(missing, ", "));
}

}  // namespace

void begin_with_weights(const std::filesystem::path& model, Network& network) {
  const std::shared_ptr<Network> stored = load_network(model);
  const std::vector<std::string>&from = stored->config().features, &to = network.config().features;
  const auto source = stored->named_parameters();
  const auto target = network.named_parameters();
  for (const auto& parameter : source)
    if (target.find(parameter.key()) == nullptr)
      fail_usage(
          "init: {} (network '{}') has '{}', which this run's network '{}' has not; give both the same "
          "layers",
          model.string(), stored->config().name, parameter.key(), network.config().name);

  const torch::NoGradGuard no_graph;
  for (auto& parameter : network.named_parameters()) {
    const torch::Tensor* found = source.find(parameter.key());
    if (found == nullptr && may_be_missing(parameter.key())) continue;
    if (found == nullptr)
      fail_usage(
          "init: {} (network '{}') has no '{}', which this run's network '{}' has; give both the same layers",
          model.string(), stored->config().name, parameter.key(), network.config().name);
    const torch::Tensor value =
        parameter.key() == kFirstLayer && from != to ? with_features(*found, from, to) : *found;
    if (value.sizes() != parameter.value().sizes())
      fail_usage("init: '{}' of {} has the shape [{}], of this run's network [{}]; give both the same sizes",
                 parameter.key(), model.string(), fmt::join(value.sizes().vec(), ", "),
                 fmt::join(parameter.value().sizes().vec(), ", "));
    parameter.value().copy_(value);
  }
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
