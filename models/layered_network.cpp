#include "models/layered_network.h"

namespace ld {

using torch::Tensor;

LayeredNetwork::Layers::Layers(const std::vector<Tensor>& tensors)
    : context(tensors[0]),
      partition{tensors[1], tensors[2], tensors[3], tensors.size() > 5 ? tensors[5] : Tensor(), tensors[4]} {}

std::vector<Tensor> LayeredNetwork::Layers::tensors() const {
  std::vector<Tensor> tensors = {context, partition.log_n, partition.radiance, partition.opacity,
                                 partition.embedding};
  if (partition.transmittance.defined()) tensors.push_back(partition.transmittance);
  return tensors;
}

LayeredNetwork::Layers LayeredNetwork::Layers::of_rows(int64_t begin, int64_t end) const {
  std::vector<Tensor> parts = tensors();
  for (Tensor& part : parts) part = rows(part, begin, end);
  return Layers(parts);
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
    std::vector<Tensor> made =
        Layers(here, partition(logits, strip.valid, strip.radiance, embedding, compositing()))
            .tensors();  // eq. 1 and 2
    made.erase(made.begin());
    return made;
  });
  parts.insert(parts.begin(), c);
  return Layers(parts);
}

int64_t LayeredNetwork::layers_row_bytes(const PictureSize& size) const {
  // Of a layer: embedding, radiance, opacity, transmittance and log n; then what they are filtered to and the
  // filter's sums.
  const int64_t floats = config().unet.context + config().layers * (config().sample_reducer.back() + 6 + 24);
  return 2 * size.batch * floats * size.width * int64_t(sizeof(float));
}

}  // namespace ld
