#include "models/sample_splat_network.h"

#include <limits>

#include "ops/generated_filter.h"

namespace ld {

using torch::Tensor;

namespace {

/// Features in which a sample that is not valid has those of the pixel's first valid one. Its kernel weighs
/// nothing, but its logits would count in m_p; as a copy they change no bit of it.
Tensor with_valid_features(const Tensor& features, const Tensor& valid) {
  const Tensor drawn = valid.ne(0);
  if (drawn.all().item<bool>()) return features;
  const Tensor own = at::arange(valid.size(1), valid.options().dtype(torch::kInt64)).view({1, -1, 1, 1, 1});
  const Tensor first = drawn.to(torch::kUInt8).argmax(1, /*keepdim=*/true);
  return features.gather(1, at::where(drawn, own, first).expand(features.sizes()));
}

}  // namespace

SampleSplatNetwork::SampleSplatNetwork(const NetworkConfig& config)
    : ContextNetwork(config, channel_count(config.features)),
      kernel_generator_(register_module("kernel_generator",
                                        std::make_shared<KernelGenerator>(config, config.unet.context))) {}

Tensor SampleSplatNetwork::denoise(NetworkInput input) {
  input.features = with_valid_features(input.features, input.valid);
  const SampleEmbeddings embeddings(*sample_reducer_, std::move(input.features));  // E_xys
  const Tensor context = unet_->forward(embeddings.mean(input.valid));             // C_xy
  const Tensor log_n = at::zeros_like(input.valid)
                           .masked_fill(input.valid.eq(0), -std::numeric_limits<double>::infinity())
                           .squeeze(2);
  const int64_t radius = config().kernel_size / 2, height = embeddings.height();
  return in_strips(height, strip_rows(height, embeddings.row_bytes()), [&](int64_t begin, int64_t end) {
    const int64_t first = std::max<int64_t>(begin - radius, 0), last = std::min(end + radius, height);
    const Tensor filtered = generated_splat_joint(
        kernel_generator_->weights(), embeddings.of_rows(first, last), rows(context, first, last),
        rows(log_n, first, last), rows(input.radiance, first, last));
    return std::vector<Tensor>{rows(filtered, begin - first, end - first)};
  })[0];
}

}  // namespace ld
