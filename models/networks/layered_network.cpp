#include "models/networks/layered_network.h"

namespace ld {

using torch::Tensor;

std::vector<Tensor> LayeredNetwork::Layers::tensors() const {
  std::vector<Tensor> tensors = {context, partition.log_n, partition.radiance, partition.opacity,
                                 partition.embedding};
  if (partition.transmittance.defined()) tensors.push_back(partition.transmittance);
  if (modulators.defined()) tensors.push_back(modulators);
  return tensors;
}

LayeredNetwork::Layers LayeredNetwork::layers_of(const std::vector<Tensor>& tensors) const {
  const bool alpha = compositing() == Compositing::alpha;
  return {tensors[0],
          {tensors[1], tensors[2], tensors[3], alpha ? tensors[5] : Tensor(), tensors[4]},
          modulation_ ? tensors.back() : Tensor()};
}

LayeredNetwork::Layers LayeredNetwork::layers_of_rows(const Layers& layers, int64_t begin,
                                                      int64_t end) const {
  std::vector<Tensor> parts = layers.tensors();
  for (Tensor& part : parts) part = rows(part, begin, end);
  return layers_of(parts);
}

LayeredNetwork::Layers LayeredNetwork::make_layers(const InputSource& input,
                                                   const SampleEmbeddings& embeddings, const Context& context,
                                                   int64_t begin, int64_t end) const {
  const Tensor c = context_rows(context, begin, end);
  const int64_t step = short_strip_rows(end - begin, embeddings.row_bytes(config().layers));
  std::vector<Tensor> parts = in_strips(begin, end, step, [&](int64_t first, int64_t last) {
    const NetworkInput strip = input.rows(first, last);
    const Tensor embedding = embeddings.of_rows(strip, first, last);  // E_xys
    const Tensor here = rows(c, first - begin, last - begin);
    const Tensor logits = sample_partitioner_->forward(embedding, here);
    Layers made = {here, partition(logits, strip.valid, strip.radiance, embedding, compositing()), {}};
    made.partition.log_n = weighed(made.partition.log_n, made.partition.embedding, here);
    made.modulators = modulators_of(strip);
    std::vector<Tensor> tensors = made.tensors();  // eq. 1 and 2
    tensors.erase(tensors.begin());
    return tensors;
  });
  parts.insert(parts.begin(), c);
  return layers_of(parts);
}

Kernels LayeredNetwork::kernels_of_layers(const InputSource& input, const KernelGenerator& generator) const {
  const SampleEmbeddings embeddings(*sample_reducer_, input);
  const Context context =
      make_context([&](int64_t begin, int64_t end) { return embeddings.mean(begin, end); }, input, 1);
  const Layers layers = make_layers(input, embeddings, context, 0, input.sizes().height);
  return {generator.logits(layers.partition.embedding, layers.context), layers.partition.log_n,
          /*of_layers=*/true};
}

int64_t LayeredNetwork::layers_row_bytes(const PictureSize& size) const {
  // Of a layer: embedding, radiance, opacity, transmittance and log n; then what they are filtered to and the
  // filter's sums.
  const int64_t further = radiance_channels() - 3;  // of a second form of the radiance
  const int64_t floats = config().unet.context + 2 * further +
                         config().layers * (config().sample_reducer.back() + 6 + 24 + 5 * further);
  return 2 * size.batch * floats * size.width * int64_t(sizeof(float));
}

}  // namespace ld
