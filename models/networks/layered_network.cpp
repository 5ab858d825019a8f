#include "models/networks/layered_network.h"

#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

Partition LayeredNetwork::make_layers(const NetworkInput& input, const Tensor& embedding,
                                      const Tensor& context) const {
  const Tensor logits = sample_partitioner_->forward(embedding, context);
  Partition layers = partition(logits, input.valid, input.radiance, embedding, compositing());
  layers.log_n = weighed(layers.log_n, layers.embedding, context);
  return layers;
}

Kernels LayeredNetwork::kernels_of_layers(const NetworkInput& input, const KernelGenerator& generator) const {
  const Tensor embedding = sample_reducer_->forward(input.features);
  const Tensor context = unet_->forward(masked_mean(embedding, input.valid));
  const Partition layers = make_layers(input, embedding, context);
  return {generator.logits(layers.embedding, context), layers.log_n, /*of_layers=*/true};
}

}  // namespace ld
