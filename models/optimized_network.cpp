#include "models/optimized_network.h"

#include <limits>

#include "models/compositor.h"

namespace ld {

using torch::Tensor;

OptimizedNetwork::OptimizedNetwork(const NetworkConfig& config) : LayeredNetwork(config) {
  for (int64_t i = 0; i < config.levels; ++i)
    kernel_generators_.push_back(
        register_module("kernel_generator" + std::to_string(i),
                        std::make_shared<KernelGenerator>(config, UNet::feature_channels(config.unet, i),
                                                          i == 0 ? config.levels : 0)));  // lambda_i
}

Tensor OptimizedNetwork::denoise(NetworkInput input) {
  const Layers layers = make_layers(std::move(input), config().levels);
  const int64_t height = layers.context[0].size(2), width = layers.context[0].size(3),
                taps = config().kernel_size * config().kernel_size;
  const std::vector<PyramidLevel> pyramid = layer_pyramid(layers.partition, config().levels);

  std::vector<Tensor> pictures, log_coverage;
  for (int64_t i = 0; i < config().levels; ++i) {
    const PyramidLevel& level = pyramid[size_t(i)];
    const Tensor global = filter_and_composite(kernel_generators_[size_t(i)]->outputs(0, taps), level.layers,
                                               layers.context[size_t(i)], compositing());  // G_i
    // A pixel that received nothing is 0 in G_i. Upscaling blends it with its neighbours, and dividing by
    // what the upscaled pixel has of those that received something leaves their mean.
    const Tensor coverage = upscale(received(level), i, height, width);
    pictures.push_back(upscale(global, i, height, width) / coverage.masked_fill(coverage.eq(0), 1));
    log_coverage.push_back(coverage.log());
  }

  const Tensor known = at::cat(log_coverage, 1);  // -inf for a level without anything to say
  const Tensor nothing = known.eq(-std::numeric_limits<double>::infinity()).all(1, /*keepdim=*/true);
  const Tensor logits = level_logits(pyramid[0], layers.context[0]) + known.masked_fill(nothing, 0);
  const Tensor lambda = at::softmax(logits, 1).unsqueeze(2);       // [B, levels, 1, H, W]
  return weighted_sum(lambda, at::stack(pictures, 1)).squeeze(1);  // eq. 10
}

/// Logits of lambda_i, [B, levels, H, W].
Tensor OptimizedNetwork::level_logits(const PyramidLevel& finest, const Tensor& context) const {
  const int64_t taps = config().kernel_size * config().kernel_size;
  return fully_connected(finest.layers.embedding.narrow(1, 0, 1), context,
                         kernel_generators_[0]->outputs(taps, config().levels), /*activate_last=*/false)
      .squeeze(1);
}

/// 1 where the kernels of a level reach from a pixel with samples, else 0, [B, 1, H, W]: such a weight is
/// never 0, however small (ops/kernel_splat.h).
Tensor OptimizedNetwork::received(const PyramidLevel& level) const {
  const int64_t kernel = config().kernel_size;
  return at::max_pool2d(level.pixels.gt(0).to(level.pixels.scalar_type()), kernel, /*stride=*/1, kernel / 2);
}

/// A picture of level `level` at full resolution [B, C, height, width].
Tensor OptimizedNetwork::upscale(const Tensor& coarse, int64_t level, int64_t height, int64_t width) const {
  if (level == 0) return coarse;
  const std::vector<int64_t> size = {coarse.size(2) << level, coarse.size(3) << level};
  const Tensor fine = config().unet.upsampling == "bilinear"
                          ? at::upsample_bilinear2d(coarse, size, /*align_corners=*/false)
                          : at::upsample_nearest2d(coarse, size);
  return fine.narrow(2, 0, height).narrow(3, 0, width);
}

}  // namespace ld
