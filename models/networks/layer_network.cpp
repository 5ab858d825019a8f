#include "models/networks/layer_network.h"

#include "models/compositor.h"
#include "models/networks/registry.h"

namespace ld {

using torch::Tensor;

LayerNetwork::LayerNetwork(const NetworkConfig& config)
    : LayeredNetwork(config),
      kernel_generator_(register_module("kernel_generator",
                                        std::make_shared<KernelGenerator>(config, config.unet.context))) {}

/// The whole network but its last step: use(layers of a strip, its first row) returns pictures of those rows.
template <class Use>
auto LayerNetwork::in_layer_strips(const InputSource& input, const Use& use) {
  const SampleEmbeddings embeddings(*sample_reducer_, input);
  const Context context =
      make_context([&](int64_t begin, int64_t end) { return embeddings.mean(begin, end); }, input, 1);
  const InputSource::Sizes sizes = input.sizes();
  const PictureSize size = {sizes.batch, sizes.height, sizes.width};
  return in_reaching_strips(
      size.height, second_half_rows(size, layers_row_bytes(size)), filter_reach(),
      [&](int64_t begin, int64_t end) { return make_layers(input, embeddings, context, begin, end); },
      [&](const Layers& made, int64_t first, int64_t begin, int64_t end) {
        return rows_of(use(made, first), begin - first, end - first);
      });
}

Tensor LayerNetwork::denoise(const InputSource& input) {
  return in_layer_strips(input, [&](const Layers& layers, int64_t first_row) {
    const Tensor filtered = filter_and_composite(kernel_generator_->kernels(), layers.partition,
                                                 layers.context, compositing(), first_row);
    return modulated(filtered, layers.modulators, layers.context);
  });
}

Kernels LayerNetwork::make_kernels(const InputSource& input) {
  return kernels_of_layers(input, *kernel_generator_);
}

int64_t LayerNetwork::memory_bytes(int64_t, int64_t height, int64_t width) const {
  const PictureSize size = {1, height, width};
  return memory_of(size, 1, layers_row_bytes(size), 3 * height * width * int64_t(sizeof(float)));
}

LayerPictures LayerNetwork::layers(const InputSource& input) {
  return in_layer_strips(
      admit(input), [&](const Layers& layers, int64_t first_row) { return looked_at(layers, first_row); });
}

LayerPictures LayerNetwork::looked_at(const Layers& made, int64_t first_row) const {
  const Partition& layers = made.partition;
  const int64_t count = layers.log_n.size(1);
  const Tensor radiance = layers.radiance.narrow(2, radiance_channels() - 3, 3);  // as it is
  const auto filter = [&](const Tensor& values) {
    return generated_splat(kernel_generator_->kernels(), layers.embedding, made.context, layers.log_n, values,
                           first_row);
  };
  if (compositing() == Compositing::weighted) {
    // The joint mean of "belongs to layer l" is filtered w_l over the sum of all filtered w.
    const Tensor belongs = at::eye(count, layers.radiance.options())
                               .view({1, count, count, 1, 1})
                               .expand({layers.radiance.size(0), count, count, layers.radiance.size(3),
                                        layers.radiance.size(4)});
    const Tensor weight = generated_splat_joint(kernel_generator_->kernels(), layers.embedding, made.context,
                                                layers.log_n, belongs, first_row)
                              .unsqueeze(2);
    const Tensor filtered = filter(at::cat({radiance, layers.opacity}, 2));
    return {radiance, filtered.narrow(2, 0, 3), filtered.narrow(2, 3, 1), weight};
  }
  const Tensor filtered = filter(at::cat({radiance, layers.opacity, layers.transmittance}, 2));
  const Tensor opacity = filtered.narrow(2, 3, 1), transmittance = filtered.narrow(2, 4, 1);
  std::vector<Tensor> weights;
  Tensor visible = at::ones_like(transmittance.select(1, 0));  // what the layers in front let through
  for (int64_t l = 0; l < count; ++l) {
    weights.push_back(visible * opacity.select(1, l));
    visible = visible * transmittance.select(1, l);
  }
  return {radiance, filtered.narrow(2, 0, 3), opacity, at::stack(weights, 1)};
}

LayerStages LayerNetwork::stages(const NetworkInput& given) {
  check_input(given, config());
  const int64_t height = given.features.size(3);
  const WholeInput input(admit(WholeInput(given)).rows(0, height));
  const SampleEmbeddings embeddings(*sample_reducer_, input);
  LayerStages stages;
  stages.embedding = embeddings.of_rows(input.rows(0, height), 0, height);
  const Context context =
      make_context([&](int64_t begin, int64_t end) { return embeddings.mean(begin, end); }, input, 1);
  const Layers made = make_layers(input, embeddings, context, 0, height);
  stages.context = made.context;
  stages.partition_logits = sample_partitioner_->forward(stages.embedding, stages.context);
  stages.layers = made.partition;
  stages.output = modulated(
      filter_and_composite(kernel_generator_->kernels(), made.partition, stages.context, compositing()),
      made.modulators, made.context);
  stages.pictures = looked_at(made, 0);
  return stages;
}

Tensor LayerNetwork::kernels_at(const InputSource& given, int64_t x, int64_t y) {
  const AdmittedInput input = admit(given);
  const SampleEmbeddings embeddings(*sample_reducer_, input);
  const Context context =
      make_context([&](int64_t begin, int64_t end) { return embeddings.mean(begin, end); }, input, 1);
  const Layers made = make_layers(input, embeddings, context, y, y + 1);
  const Tensor logits = kernel_generator_->logits(made.partition.embedding, made.context)
                            .select(4, x)
                            .select(3, 0);  // [B, N, K*K]
  const Tensor log_n = made.partition.log_n.select(3, x).select(2, 0).unsqueeze(2);
  return at::softmax((logits + log_n).flatten(1), 1).view(logits.sizes()).nan_to_num(0);
}

std::shared_ptr<Network> make_layer_network(const NetworkConfig& config) {
  return std::make_shared<LayerNetwork>(config);
}

}  // namespace ld
