#include "models/networks/layered_network.h"

namespace ld {

using torch::Tensor;

LayeredNetwork::Layers LayeredNetwork::make_layers(const InputSource& input,
                                                   const SampleEmbeddings& embeddings, const Context& context,
                                                   int64_t begin, int64_t end) const {
  const Tensor c = context_rows(context, begin, end);
  const int64_t step = short_strip_rows(end - begin, embeddings.row_bytes(config().layers));
  Layers layers = in_strips(begin, end, step, [&](int64_t first, int64_t last) {
    const NetworkInput strip = input.rows(first, last);
    const Tensor embedding = embeddings.of_rows(strip, first, last);  // E_xys
    const Tensor here = rows(c, first - begin, last - begin);
    const Tensor logits = sample_partitioner_->forward(embedding, here);
    Layers made;
    made.partition = partition(logits, strip.valid, strip.radiance, embedding, compositing());  // eq. 1 and 2
    made.partition.log_n = weighed(made.partition.log_n, made.partition.embedding, here);
    made.modulators = modulators_of(strip);
    return made;
  });
  layers.context = c;
  return layers;
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
