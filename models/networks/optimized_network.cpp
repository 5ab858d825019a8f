#include "models/networks/optimized_network.h"

#include "models/compositor.h"
#include "models/networks/registry.h"
#include "ops/expect_tensor.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

OptimizedNetwork::OptimizedNetwork(const NetworkConfig& config) : LayeredNetwork(config) {
  for (int64_t i = 0; i < config.levels; ++i)
    kernel_generators_.push_back(
        register_module("kernel_generator" + std::to_string(i),
                        std::make_shared<KernelGenerator>(config, UNet::feature_channels(config.unet, i),
                                                          i == 0 ? config.levels : 0)));  // lambda_i
}

Tensor OptimizedNetwork::denoise(const NetworkInput& input, NetworkState& /*state*/) {
  const Tensor embedding = sample_reducer_->forward(input.features);  // E_xys
  const std::vector<Tensor> features =
      unet_->features(masked_mean(embedding, input.valid), config().levels);  // C_xy, then of each level
  const Partition layers = make_layers(input, embedding, features[0]);        // eq. 1 and 2
  const std::vector<PyramidLevel> pyramid = layer_pyramid(layers, config().levels);
  const Tensor logits = fully_connected(layers.embedding.narrow(1, 0, 1), features[0],
                                        kernel_generators_[0]->further(), /*activate_last=*/false)
                            .squeeze(1);  // of lambda_i
  std::vector<Tensor> pictures, received_by;
  for (size_t i = 0; i < pyramid.size(); ++i) {
    pictures.push_back(filter_and_composite(kernel_generators_[i]->kernels(), pyramid[i].layers, features[i],
                                            compositing()));  // G_i
    received_by.push_back(received(pyramid[i].pixels));
  }
  return modulated(blended(logits, pictures, received_by), input, features[0]);
}

/// eq. 10. logits [B, levels, H, W]; pictures [B, C, H / 2^i, W / 2^i]; received [B, 1, H / 2^i, W / 2^i]: 1
/// where a level received something, else 0.
Tensor OptimizedNetwork::blended(const Tensor& logits, const std::vector<Tensor>& pictures,
                                 const std::vector<Tensor>& received) const {
  std::vector<Tensor> upscaled, log_coverage;
  for (size_t i = 0; i < pictures.size(); ++i) {
    // A pixel that received nothing is 0 in G_i. Upscaling blends it with its neighbours, and dividing by
    // what the upscaled pixel has of those that received something leaves their mean.
    const Tensor coverage = upscale(received[i], int64_t(i), logits);
    upscaled.push_back(upscale(pictures[i], int64_t(i), logits) / coverage.masked_fill(coverage.eq(0), 1));
    log_coverage.push_back(coverage.log());
  }
  const Tensor known = at::cat(log_coverage, 1);  // -inf for a level without anything to say
  const Tensor nothing = known.eq(-kInfinity).all(1, /*keepdim=*/true);
  const Tensor lambda = at::softmax(logits + known.masked_fill(nothing, 0), 1).unsqueeze(2);
  return weighted_sum(lambda, at::stack(upscaled, 1)).squeeze(1);
}

/// 1 where the kernels of a level reach from a pixel with samples, else 0, [B, 1, H, W]: such a weight is
/// never 0, however small (ops/kernel_splat.h).
Tensor OptimizedNetwork::received(const Tensor& pixels) const {
  const int64_t kernel = config().kernel_size;
  return at::max_pool2d(pixels.gt(0).to(pixels.scalar_type()), kernel, /*stride=*/1, kernel / 2);
}

/// A picture of level `level` at the resolution of `fine`.
Tensor OptimizedNetwork::upscale(const Tensor& coarse, int64_t level, const Tensor& fine) const {
  if (level == 0) return coarse;
  const std::vector<int64_t> size = {coarse.size(2) << level, coarse.size(3) << level};
  const Tensor scaled = config().unet.upsampling == "bilinear"
                            ? at::upsample_bilinear2d(coarse, size, /*align_corners=*/false)
                            : at::upsample_nearest2d(coarse, size);
  return scaled.narrow(2, 0, fine.size(2)).narrow(3, 0, fine.size(3));
}

void OptimizedNetwork::begin_sharp() {
  const torch::NoGradGuard no_gradient;
  Tensor bias = kernel_generators_[0]->further().biases.back();
  bias.narrow(0, 0, 1).fill_(3);
}

Kernels OptimizedNetwork::make_kernels(const NetworkInput& input) {
  return kernels_of_layers(input, *kernel_generators_[0]);
}

std::shared_ptr<Network> make_optimized_network(const NetworkConfig& config) {
  return std::make_shared<OptimizedNetwork>(config);
}

}  // namespace ld
