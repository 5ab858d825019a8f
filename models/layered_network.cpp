#include "models/layered_network.h"

namespace ld {

using torch::Tensor;

LayeredNetwork::Layers LayeredNetwork::make_layers(NetworkInput input, int64_t resolutions) const {
  const SampleEmbeddings embeddings(*sample_reducer_, std::move(input.features));  // E_xys
  Layers layers;
  layers.context = unet_->features(embeddings.mean(input.valid), resolutions);  // C_xy

  const int64_t height = embeddings.height(),
                step = short_strip_rows(height, embeddings.row_bytes(config().layers));
  const std::vector<Tensor> parts = in_strips(height, step, [&](int64_t begin, int64_t end) {
    const Tensor embedding = embeddings.of_rows(begin, end);
    const Tensor logits = sample_partitioner_->forward(embedding, rows(layers.context[0], begin, end));
    const Partition p = partition(logits, rows(input.valid, begin, end), rows(input.radiance, begin, end),
                                  embedding, compositing());  // eq. 1 and 2
    std::vector<Tensor> of_rows = {p.log_n, p.radiance, p.opacity, p.embedding};
    if (p.transmittance.defined()) of_rows.push_back(p.transmittance);
    return of_rows;
  });
  layers.partition.log_n = parts[0];
  layers.partition.radiance = parts[1];
  layers.partition.opacity = parts[2];
  layers.partition.embedding = parts[3];
  if (parts.size() > 4) layers.partition.transmittance = parts[4];
  return layers;
}

}  // namespace ld
