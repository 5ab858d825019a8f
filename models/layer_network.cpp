#include "models/layer_network.h"

#include <algorithm>

#include "core/error.h"
#include "models/compositor.h"
#include "ops/check.h"
#include "ops/kernel_splat.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

namespace {

constexpr double kLargestFeature = 65504;  // half's range: what files hold; more could overflow a layer
constexpr int64_t kLogitBytes = int64_t(256) << 20;  // of kernel logits that inference holds at a time

void check(const NetworkInput& input, const NetworkConfig& config) {
  const auto type = floating_type("network: features", input.features);
  expect_tensor("network: features", "[B, S, F, H, W]", input.features,
                {kAnySize, kAnySize, channel_count(config.features), kAnySize, kAnySize}, type);
  const auto sizes = input.features.sizes();
  if (input.features.numel() == 0)
    fail("network: features are empty, expected at least one sample of one pixel");
  expect_tensor("network: radiance", "[B, S, 3, H, W]", input.radiance,
                {sizes[0], sizes[1], 3, sizes[3], sizes[4]}, type);
  expect_tensor("network: valid", "[B, S, 1, H, W]", input.valid, {sizes[0], sizes[1], 1, sizes[3], sizes[4]},
                type);
}

/// The features within half's range; a copy only where one exceeds it.
Tensor bounded(const Tensor& features) {
  const auto [low, high] = at::aminmax(features.detach());
  const bool fits = low.item<double>() >= -kLargestFeature && high.item<double>() <= kLargestFeature;
  return fits ? features : features.clamp(-kLargestFeature, kLargestFeature);
}

}  // namespace

LayerNetwork::LayerNetwork(const NetworkConfig& config)
    : Network(config),
      sample_reducer_(register_module("sample_reducer", std::make_shared<SampleReducer>(config))),
      unet_(register_module("unet", std::make_shared<UNet>(config.sample_reducer.back(), config.unet))),
      sample_partitioner_(register_module("sample_partitioner", std::make_shared<SamplePartitioner>(config))),
      kernel_generator_(register_module("kernel_generator", std::make_shared<KernelGenerator>(config))) {}

Tensor LayerNetwork::run(const NetworkInput& input, LayerStages* stages) {
  check(input, config());
  Tensor embedding = sample_reducer_->forward(bounded(input.features));                // E_xys
  const Tensor context = unet_->forward(masked_mean(embedding, input.valid));          // C_xy
  Tensor logits = sample_partitioner_->forward(embedding, context);                    // of w_xys^l, eq. 1
  const Partition layers = partition(logits, input.valid, input.radiance, embedding);  // eq. 2
  if (stages != nullptr) *stages = {embedding, context, logits, layers, {}, {}, {}};
  embedding.reset();  // per-sample memory, the largest of all at inference
  logits.reset();

  const Tensor filtered = filter(layers, context);  // eq. 3 and 4
  const Tensor radiance = filtered.narrow(2, 0, 3), transmittance = filtered.narrow(2, 3, 1);
  const Tensor output = composite_alpha(radiance, transmittance);  // eq. 5
  if (stages != nullptr) {
    stages->radiance = radiance;
    stages->transmittance = transmittance;
    stages->output = output;
  }
  return output;
}

LayerStages LayerNetwork::stages(const NetworkInput& input) {
  LayerStages stages;
  run(input, &stages);
  return stages;
}

/// Filtered radiance and transmittance [B, N, 3 + 1, H, W]. Without gradients to keep, strips of rows in
/// turn, so that the kernels of the whole picture (2.4 GB a layer at 1920x1080 with 17x17 taps) never exist
/// at once.
Tensor LayerNetwork::filter(const Partition& layers, const Tensor& context) const {
  const int64_t height = context.size(2);
  const int64_t row_bytes = context.size(0) * config().layers * config().kernel_size * config().kernel_size *
                            context.size(3) * int64_t(context.element_size());
  const int64_t rows = at::GradMode::is_enabled() ? height : std::max<int64_t>(kLogitBytes / row_bytes, 16);
  std::vector<Tensor> strips;
  for (int64_t begin = 0; begin < height; begin += rows)
    strips.push_back(filter_rows(layers, context, begin, std::min(begin + rows, height)));
  return strips.size() == 1 ? strips[0] : at::cat(strips, 3);
}

Tensor LayerNetwork::filter_rows(const Partition& layers, const Tensor& context, int64_t begin,
                                 int64_t end) const {
  const int64_t radius = config().kernel_size / 2;  // rows further away send nothing to [begin, end)
  const int64_t first = std::max<int64_t>(begin - radius, 0), last = std::min(end + radius, context.size(2));
  const auto rows = [&](const Tensor& t) { return t.narrow(t.dim() - 2, first, last - first); };
  const Tensor kernels = kernel_generator_->forward(rows(layers.embedding), rows(context));
  const Tensor values = at::cat({rows(layers.radiance), rows(layers.transmittance)}, 2);
  return kernel_splat(kernels, rows(layers.log_n), values).narrow(3, begin - first, end - begin);
}

}  // namespace ld
