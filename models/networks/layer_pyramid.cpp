#include "models/networks/layer_pyramid.h"

#include <cmath>
#include <limits>

#include "ops/expect_tensor.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

namespace {

/// planes [M, C, H, W] -> [M, 4, C, ceil(H / 2), ceil(W / 2)]: the four pixels that become one; `missing`
/// stands for those beyond an odd border.
Tensor four_pixels(const Tensor& planes, double missing) {
  const Tensor even = at::constant_pad_nd(planes, {0, planes.size(3) % 2, 0, planes.size(2) % 2}, missing);
  const auto pixel = [&](int64_t dy, int64_t dx) {
    return even.slice(2, dy, c10::nullopt, 2).slice(3, dx, c10::nullopt, 2);
  };
  return at::stack({pixel(0, 0), pixel(0, 1), pixel(1, 0), pixel(1, 1)}, 1);
}

PyramidLevel halve(const PyramidLevel& fine) {
  const Partition& layers = fine.layers;
  const int64_t batch = layers.log_n.size(0), count = layers.log_n.size(1);
  PyramidLevel coarse;

  const Tensor log_n = four_pixels(layers.log_n.flatten(0, 1).unsqueeze(1), -kInfinity);  // [B*N, 4, 1, h, w]
  // Where all four are empty: softmax and log-sum-exp of -inf alone are NaN, so they see zeros there.
  const Tensor empty = log_n.detach().eq(-kInfinity).all(1, /*keepdim=*/true);
  const Tensor counted = log_n.masked_fill(empty, 0);
  const Tensor mean =
      (at::logsumexp(counted, 1, /*keepdim=*/true) - std::log(4.0)).masked_fill(empty, -kInfinity);
  coarse.layers.log_n = mean.squeeze(1).squeeze(1).unflatten(0, {batch, count});

  const Tensor ratios =
      layers.transmittance.defined() ? at::cat({layers.radiance, layers.transmittance}, 2) : layers.radiance;
  const Tensor means = weighted_sum(at::softmax(counted, 1), four_pixels(ratios.flatten(0, 1), 0))
                           .squeeze(1)
                           .unflatten(0, {batch, count});
  const int64_t channels = layers.radiance.size(2);
  coarse.layers.radiance = means.narrow(2, 0, channels);
  if (layers.transmittance.defined()) coarse.layers.transmittance = means.narrow(2, channels, 1);

  const Tensor pixels = four_pixels(fine.pixels, 0);
  coarse.pixels = pixels.sum(1);
  coarse.layers.embedding = weighted_sum(pixels / coarse.pixels.clamp_min(1).unsqueeze(1),
                                         four_pixels(layers.embedding.flatten(1, 2), 0))
                                .squeeze(1)
                                .unflatten(1, {count, layers.embedding.size(2)});
  return coarse;
}

}  // namespace

std::vector<PyramidLevel> layer_pyramid(const Partition& layers, int64_t levels) {
  const Tensor drawn = layers.log_n.detach().gt(-kInfinity).any(1, /*keepdim=*/true);
  std::vector<PyramidLevel> pyramid = {{layers, drawn.to(layers.log_n.scalar_type())}};
  while (int64_t(pyramid.size()) < levels) pyramid.push_back(halve(pyramid.back()));
  return pyramid;
}

}  // namespace ld
