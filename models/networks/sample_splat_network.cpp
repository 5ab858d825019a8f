#include "models/networks/sample_splat_network.h"

#include "models/networks/registry.h"
#include "ops/expect_tensor.h"
#include "ops/generated_filter.h"
#include "ops/weighted_sum.h"

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

/// 0, or -inf for a sample that is not valid, [B, S, H, W].
Tensor log_weights(const Tensor& valid) {
  return at::zeros_like(valid).masked_fill(valid.eq(0), -kInfinity).squeeze(2);
}

}  // namespace

SampleSplatNetwork::SampleSplatNetwork(const NetworkConfig& config)
    : ContextNetwork(config, channel_count(config.features)),
      kernel_generator_(register_module("kernel_generator",
                                        std::make_shared<KernelGenerator>(config, config.unet.context))) {}

Tensor SampleSplatNetwork::denoise(const NetworkInput& input, NetworkState& /*state*/) {
  const Tensor features = with_valid_features(input.features, input.valid);
  const Tensor embedding = sample_reducer_->forward(features);                 // E_xys
  const Tensor context = unet_->forward(masked_mean(embedding, input.valid));  // C_xy
  const Tensor log_n = weighed(log_weights(input.valid), embedding, context);
  const Tensor filtered =
      generated_splat_joint(kernel_generator_->kernels(), embedding, context, log_n, input.radiance);
  return modulated(filtered, input, context);
}

Kernels SampleSplatNetwork::make_kernels(const NetworkInput& input) {
  const Tensor embedding = sample_reducer_->forward(with_valid_features(input.features, input.valid));
  const Tensor context = unet_->forward(masked_mean(embedding, input.valid));
  return {kernel_generator_->logits(embedding, context),
          weighed(log_weights(input.valid), embedding, context)};
}

std::shared_ptr<Network> make_sample_splat_network(const NetworkConfig& config) {
  return std::make_shared<SampleSplatNetwork>(config);
}

}  // namespace ld
