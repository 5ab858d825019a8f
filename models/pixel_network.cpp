#include "models/pixel_network.h"

#include <limits>

#include "models/sample_statistics.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

PixelNetwork::PixelNetwork(const NetworkConfig& config)
    : ContextNetwork(config, 2 * channel_count(config.features)),
      kernel_generator_(register_module("kernel_generator",
                                        std::make_shared<KernelGenerator>(config, config.unet.context))) {}

Tensor PixelNetwork::denoise(NetworkInput input) {
  const Tensor statistics = sample_statistics(input.features, input.valid);
  input.features = Tensor();
  const Tensor embedding = sample_reducer_->forward(statistics);     // of the pixel
  const Tensor context = unet_->forward(embedding.squeeze(1));       // C_xy
  const Tensor radiance = masked_mean(input.radiance, input.valid);  // the pixel aggregate
  const Tensor drawn = input.valid.ne(0).any(1).squeeze(1);
  const Tensor log_n = at::zeros(drawn.sizes(), radiance.options())
                           .masked_fill(drawn.logical_not(), -std::numeric_limits<double>::infinity());
  return filter(kernel_generator_->weights(), embedding, context, log_n, radiance);
}

}  // namespace ld
