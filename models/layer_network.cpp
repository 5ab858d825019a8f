#include "models/layer_network.h"

#include "models/compositor.h"
#include "ops/kernel_splat.h"

namespace ld {

using torch::Tensor;

LayerNetwork::LayerNetwork(const NetworkConfig& config)
    : LayeredNetwork(config),
      kernel_generator_(register_module("kernel_generator",
                                        std::make_shared<KernelGenerator>(config, config.unet.context))) {}

Tensor LayerNetwork::denoise(NetworkInput input) {
  const Layers layers = make_layers(std::move(input), 1);
  return filter_and_composite(kernel_generator_->weights(), layers.partition, layers.context[0],
                              compositing());
}

LayerStages LayerNetwork::stages(NetworkInput input) {
  input = admit(std::move(input));
  LayerStages stages;
  stages.embedding = sample_reducer_->forward(input.features);
  const Layers made = make_layers(std::move(input), 1);
  stages.context = made.context[0];
  stages.partition_logits = sample_partitioner_->forward(stages.embedding, stages.context);
  stages.layers = made.partition;
  stages.output =
      filter_and_composite(kernel_generator_->weights(), made.partition, stages.context, compositing());

  const Partition& layers = stages.layers;
  const int64_t count = layers.log_n.size(1);
  const Tensor kernels = kernel_generator_->forward(layers.embedding, stages.context);
  stages.unfiltered_radiance = layers.radiance;
  if (compositing() == Compositing::weighted) {
    stages.radiance = kernel_splat(kernels, layers.log_n, layers.radiance);
    stages.opacity = kernel_splat(kernels, layers.log_n, layers.opacity);
    // The joint mean of "belongs to layer l" is filtered w_l over the sum of all filtered w.
    const Tensor belongs = at::eye(count, layers.radiance.options())
                               .view({1, count, count, 1, 1})
                               .expand({layers.radiance.size(0), count, count, layers.radiance.size(3),
                                        layers.radiance.size(4)});
    stages.weight = kernel_splat_joint(kernels, layers.log_n, belongs).unsqueeze(2);
    return stages;
  }
  const Tensor filtered = kernel_splat(kernels, layers.log_n,
                                       at::cat({layers.radiance, layers.opacity, layers.transmittance}, 2));
  stages.radiance = filtered.narrow(2, 0, 3);
  stages.opacity = filtered.narrow(2, 3, 1);
  const Tensor transmittance = filtered.narrow(2, 4, 1);
  std::vector<Tensor> weights;
  Tensor visible = at::ones_like(transmittance.select(1, 0));  // what the layers in front let through
  for (int64_t l = 0; l < count; ++l) {
    weights.push_back(visible * stages.opacity.select(1, l));
    visible = visible * transmittance.select(1, l);
  }
  stages.weight = at::stack(weights, 1);
  return stages;
}

}  // namespace ld
