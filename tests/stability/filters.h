// The second half of the layered denoiser with given logits, for tests of its formulas.
#pragma once

#include "models/compositor.h"
#include "ops/kernel_splat.h"
#include "ops/partition.h"
#include "tests/support/tensors.h"

namespace ld {

/// partition_logits [B, S, N, H, W], kernel_logits [B, N, K*K, H, W], valid and radiance as in
/// ops/partition.h: [B, 3, H, W].
inline torch::Tensor filter_layers(const torch::Tensor& partition_logits, const torch::Tensor& kernel_logits,
                                   const torch::Tensor& valid, const torch::Tensor& radiance,
                                   Compositing compositing) {
  const Partition layers = partition(partition_logits, valid, radiance, radiance, compositing);
  if (compositing == Compositing::weighted)
    return kernel_splat_joint(kernel_logits, layers.log_n, layers.radiance);
  const torch::Tensor filtered =
      kernel_splat(kernel_logits, layers.log_n, at::cat({layers.radiance, layers.transmittance}, 2));
  return composite_alpha(filtered.narrow(2, 0, 3), filtered.narrow(2, 3, 1));
}

/// Numbers as a trained network might give them, only larger or smaller.
struct FilterInput {
  torch::Tensor partition_logits, kernel_logits, valid, radiance;
  torch::Tensor run(Compositing compositing) const {
    return filter_layers(partition_logits, kernel_logits, valid, radiance, compositing);
  }
};

inline FilterInput filter_input(int64_t layers, int64_t kernel, int64_t samples, int64_t height,
                                int64_t width, double deviation, uint32_t seed) {
  const auto type = torch::kFloat32;
  return {random_normal({1, samples, layers, height, width}, seed, deviation).to(type),
          random_normal({1, layers, kernel * kernel, height, width}, seed + 1, deviation).to(type),
          torch::ones({1, samples, 1, height, width}),
          random_uniform({1, samples, 3, height, width}, seed + 2, 0, 4).to(type)};
}

/// Appendix A of [MH20] as printed, but for its two slips (occupancy of k >= l, division by the number of
/// samples): the joint maximum taken out, L / (n + eps) and alpha = w / (n + eps), composited with 1 - alpha.
/// In the type of its arguments.
inline torch::Tensor filter_layers_as_printed(const FilterInput& input, torch::ScalarType type,
                                              double eps = 1e-6) {
  const torch::Tensor w = torch::softmax(input.partition_logits.to(type), 2) / input.valid.size(1);
  const int64_t layers = w.size(2), taps = input.kernel_logits.size(2), height = w.size(3), width = w.size(4);
  const auto kernel = int64_t(std::lround(std::sqrt(double(taps)))), radius = kernel / 2;
  const torch::Tensor logits = input.kernel_logits.to(type);
  const torch::Tensor kernels = (logits - logits.amax({1, 2}, /*keepdim=*/true)).exp();
  const auto splat = [&](const torch::Tensor& values, int64_t l) {  // [B, C, H, W]
    const torch::Tensor sources = at::constant_pad_nd(values, {radius, radius, radius, radius}, 0);
    const torch::Tensor weights =
        at::constant_pad_nd(kernels.select(1, l), {radius, radius, radius, radius}, 0);
    torch::Tensor sum = torch::zeros_like(values);
    for (int64_t t = 0; t < taps; ++t) {
      const int64_t y = 2 * radius - t / kernel, x = 2 * radius - t % kernel;
      sum = sum + weights.narrow(1, t, 1).narrow(2, y, height).narrow(3, x, width) *
                      sources.narrow(2, y, height).narrow(3, x, width);
    }
    return sum;
  };
  torch::Tensor color = torch::zeros({1, 3, height, width}, type),
                visible = torch::ones({1, 1, height, width}, type);
  for (int64_t l = 0; l < layers; ++l) {
    const torch::Tensor weight = w.narrow(2, l, 1);
    const torch::Tensor n = splat(w.narrow(2, l, layers - l).sum(2, true).sum(1), l) + eps;
    color = color + visible * splat((weight * input.radiance.to(type)).sum(1), l) / n;
    visible = visible * (1 - splat(weight.sum(1), l) / n);
  }
  return color;
}

}  // namespace ld
