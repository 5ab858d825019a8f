#include "models/level_blend.h"

#include "ops/expect_tensor.h"
#include "ops/weighted_sum.h"

namespace ld {

using torch::Tensor;

namespace {

/// A picture of level `level` at the resolution of `fine`.
Tensor upscaled(const Tensor& coarse, int64_t level, const Tensor& fine, const UNetConfig& unet) {
  if (level == 0) return coarse;
  const std::vector<int64_t> size = {coarse.size(2) << level, coarse.size(3) << level};
  const Tensor scaled = unet.upsampling == "bilinear"
                            ? at::upsample_bilinear2d(coarse, size, /*align_corners=*/false)
                            : at::upsample_nearest2d(coarse, size);
  return scaled.narrow(2, 0, fine.size(2)).narrow(3, 0, fine.size(3));
}

}  // namespace

Tensor blend_levels(const Tensor& logits, const std::vector<Tensor>& pictures,
                    const std::vector<Tensor>& received, const UNetConfig& unet) {
  std::vector<Tensor> means, log_coverage;
  for (size_t i = 0; i < pictures.size(); ++i) {
    // A pixel that received nothing is 0 in G_i. Upscaling blends it with its neighbours, and dividing by
    // what the upscaled pixel has of those that received something leaves their mean.
    const Tensor coverage = upscaled(received[i], int64_t(i), logits, unet);
    means.push_back(upscaled(pictures[i], int64_t(i), logits, unet) /
                    coverage.masked_fill(coverage.eq(0), 1));
    log_coverage.push_back(coverage.log());
  }
  const Tensor known = at::cat(log_coverage, 1);  // -inf for a level without anything to say
  const Tensor nothing = known.eq(-kInfinity).all(1, /*keepdim=*/true);
  const Tensor lambda = at::softmax(logits + known.masked_fill(nothing, 0), 1).unsqueeze(2);
  return weighted_sum(lambda, at::stack(means, 1)).squeeze(1);
}

Tensor received_from(const Tensor& pixels, int64_t kernel) {
  return at::max_pool2d(pixels.gt(0).to(pixels.scalar_type()), kernel, /*stride=*/1, kernel / 2);
}

}  // namespace ld
