// The recurrent denoising autoencoder (models/recurrent.h) as a network, "recurrent".
#include "core/error.h"
#include "models/networks/registry.h"
#include "models/recurrent.h"

namespace ld {
namespace {

class RecurrentNetwork : public Network {
 public:
  explicit RecurrentNetwork(const NetworkConfig& config)
      : Network(config),
        autoencoder_(register_module("autoencoder", std::make_shared<RecurrentAutoencoder>(config))) {}

 private:
  torch::Tensor denoise(const NetworkInput& input, NetworkState& state) override {
    const RecurrentInput light(input, config());
    return light.picture(autoencoder_->forward(light.seen, state));
  }

  Compared predict(const NetworkInput& input, const torch::Tensor& reference, NetworkState& state) override {
    const RecurrentInput light(input, config());
    const torch::Tensor predicted = autoencoder_->forward(light.seen, state);
    return {light.picture(predicted.detach()), predicted, light.root(reference)};
  }

  Kernels make_kernels(const NetworkInput& /*input*/) override {
    fail("network '{}' has no kernels to look at: it makes the light itself", config().name);
  }

  std::shared_ptr<RecurrentAutoencoder> autoencoder_;
};

}  // namespace

std::shared_ptr<Network> make_recurrent_network(const NetworkConfig& config) {
  return std::make_shared<RecurrentNetwork>(config);
}

}  // namespace ld
