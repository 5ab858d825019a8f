#include "models/networks/layer_network.h"

#include "models/compositor.h"
#include "models/networks/registry.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

LayerNetwork::LayerNetwork(const NetworkConfig& config)
    : LayeredNetwork(config),
      kernel_generator_(register_module("kernel_generator",
                                        std::make_shared<KernelGenerator>(config, config.unet.context))) {}

LayerNetwork::Composited LayerNetwork::composited(const NetworkInput& input) const {
  const Tensor embedding = sample_reducer_->forward(input.features);                           // E_xys
  const Tensor context = unet_->forward(masked_mean(embedding, input.valid));                  // C_xy
  const Partition layers = make_layers(input, embedding, context);                             // eq. 1 and 2
  return {filter_and_composite(kernel_generator_->kernels(), layers, context, compositing()),  // eq. 3 to 6
          context};
}

Tensor LayerNetwork::denoise(const NetworkInput& input, NetworkState& /*state*/) {
  const Composited now = composited(input);
  return modulated(now.light, input, now.context);
}

Kernels LayerNetwork::make_kernels(const NetworkInput& input) {
  return kernels_of_layers(input, *kernel_generator_);
}

std::shared_ptr<Network> make_layer_network(const NetworkConfig& config) {
  return std::make_shared<LayerNetwork>(config);
}

}  // namespace ld
