#include "weights/mix_weights.h"

#include <fmt/ranges.h>

#include <map>
#include <vector>

#include "core/error.h"
#include "frame/schema.h"
#include "weights/model_file.h"

namespace ld {
namespace {

/// The one parameter whose columns are the features.
constexpr const char* kFirstLayer = "sample_reducer.0.weight";
/// Parameters that weights may lack: as they begin, they change little or nothing of a frame
/// (models/rejection.h, models/history.h, PixelPyramidNetwork::begin_sharp()).
bool may_be_missing(const std::string& parameter) {
  const std::string module = parameter.substr(0, parameter.find('.'));
  return module == "rejection" || module == "history" || module == "levels";
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

}  // namespace

void mix_in_weights(const std::filesystem::path& model, double share, Network& network,
                    const std::string& who) {
  const std::shared_ptr<Network> stored = load_network(model);
  const std::vector<std::string>&from = stored->config().features, &to = network.config().features;
  const auto source = stored->named_parameters();
  const auto target = network.named_parameters();
  for (const auto& parameter : source)
    if (target.find(parameter.key()) == nullptr)
      fail_usage(
          "{}: {} (network '{}') has '{}', which the network '{}' has not; give both the same "
          "layers",
          who, model.string(), stored->config().name, parameter.key(), network.config().name);

  const torch::NoGradGuard no_graph;
  for (auto& parameter : network.named_parameters()) {
    const torch::Tensor* found = source.find(parameter.key());
    if (found == nullptr && may_be_missing(parameter.key())) continue;
    if (found == nullptr)
      fail_usage("{}: {} (network '{}') has no '{}', which the network '{}' has; give both the same layers",
                 who, model.string(), stored->config().name, parameter.key(), network.config().name);
    const torch::Tensor value =
        parameter.key() == kFirstLayer && from != to ? with_features(*found, from, to) : *found;
    if (value.sizes() != parameter.value().sizes())
      fail_usage("{}: '{}' of {} has the shape [{}], of this network [{}]; give both the same sizes", who,
                 parameter.key(), model.string(), fmt::join(value.sizes().vec(), ", "),
                 fmt::join(parameter.value().sizes().vec(), ", "));
    parameter.value().copy_(share == 1 ? value : parameter.value() + share * (value - parameter.value()));
  }
}

}  // namespace ld
