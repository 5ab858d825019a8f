#include "models/networks/optimized_network.h"

#include "models/compositor.h"
#include "models/level_blend.h"
#include "models/networks/registry.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

OptimizedNetwork::OptimizedNetwork(const NetworkConfig& config) : LayeredNetwork(config) {
  for (int64_t i = 0; i < config.levels; ++i)
    kernel_generators_.push_back(
        register_module("kernel_generator" + std::to_string(i),
                        std::make_shared<KernelGenerator>(config, UNet::feature_channels(config.unet, i),
                                                          i == 0 ? config.levels : 0)));  // lambda_i
}

Tensor OptimizedNetwork::denoise(const NetworkInput& input, NetworkState& /*state*/) {
  const Tensor embedding = sample_reducer_->forward(input.features);  // E_xys
  const std::vector<Tensor> features =
      unet_->features(masked_mean(embedding, input.valid), config().levels);  // C_xy, then of each level
  const Partition layers = make_layers(input, embedding, features[0]);        // eq. 1 and 2
  const std::vector<PyramidLevel> pyramid = layer_pyramid(layers, config().levels);
  const Tensor logits = fully_connected(layers.embedding.narrow(1, 0, 1), features[0],
                                        kernel_generators_[0]->further(), /*activate_last=*/false)
                            .squeeze(1);  // of lambda_i
  std::vector<Tensor> pictures, received;
  for (size_t i = 0; i < pyramid.size(); ++i) {
    pictures.push_back(filter_and_composite(kernel_generators_[i]->kernels(), pyramid[i].layers, features[i],
                                            compositing()));  // G_i
    received.push_back(received_from(pyramid[i].pixels, config().kernel_size));
  }
  return modulated(blend_levels(logits, pictures, received, config().unet), input, features[0]);
}

void OptimizedNetwork::begin_sharp() {
  const torch::NoGradGuard no_gradient;
  Tensor bias = kernel_generators_[0]->further().biases.back();
  bias.narrow(0, 0, 1).fill_(3);
}

Kernels OptimizedNetwork::make_kernels(const NetworkInput& input) {
  return kernels_of_layers(input, *kernel_generators_[0]);
}

std::shared_ptr<Network> make_optimized_network(const NetworkConfig& config) {
  return std::make_shared<OptimizedNetwork>(config);
}

}  // namespace ld
