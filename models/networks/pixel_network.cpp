#include "models/networks/pixel_network.h"

#include "models/sample_statistics.h"
#include "ops/expect_tensor.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

PixelNetwork::PixelNetwork(const NetworkConfig& config)
    : ContextNetwork(config, int64_t{2} * channel_count(config.features)) {}

PixelNetwork::Pixels PixelNetwork::make_pixels(const NetworkInput& input) const {
  Pixels pixels;
  const Tensor statistics = sample_statistics(input.features, input.valid);
  const Tensor embedding = sample_reducer_->forward(statistics).squeeze(1);
  pixels.features =
      unet_->features(embedding, network_traits(config().name).has_levels ? config().levels : 1);
  pixels.context = pixels.features[0];
  pixels.embedding = embedding.unsqueeze(1);
  pixels.radiance = masked_mean(input.radiance, input.valid);
  const Tensor drawn = input.valid.ne(0).any(1);
  pixels.log_n =
      at::zeros(drawn.sizes(), input.radiance.options()).masked_fill(drawn.logical_not(), -kInfinity);
  pixels.log_n = weighed(pixels.log_n, pixels.embedding, pixels.context);
  return pixels;
}

Tensor PixelNetwork::denoise(const NetworkInput& input, NetworkState& /*state*/) {
  const Pixels pixels = make_pixels(input);
  return modulated(filter(pixels), input, pixels.context);
}

Kernels PixelNetwork::make_kernels(const NetworkInput& input) {
  const Pixels pixels = make_pixels(input);
  return {logits(pixels), pixels.log_n};
}

}  // namespace ld
