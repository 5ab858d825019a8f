// Layers that remember: the layered denoiser whose previous picture, moved to where its surfaces are now, is
// one more layer in front. Network name "layer_history".
#include "models/history.h"
#include "models/networks/layer_network.h"
#include "models/networks/registry.h"

namespace ld {
namespace {

class LayerHistoryNetwork : public LayerNetwork {
 public:
  explicit LayerHistoryNetwork(const NetworkConfig& config)
      : LayerNetwork(config), history_(register_module("history", std::make_shared<History>(config))) {}

 private:
  torch::Tensor denoise(const NetworkInput& input, NetworkState& state) override {
    const Composited now = composited(input);
    const torch::Tensor light = history_->remembered(now.light, now.context, input, config(), state);
    return modulated(light, input, now.context);
  }

  std::shared_ptr<History> history_;
};

}  // namespace

std::shared_ptr<Network> make_layer_history_network(const NetworkConfig& config) {
  return std::make_shared<LayerHistoryNetwork>(config);
}

}  // namespace ld
