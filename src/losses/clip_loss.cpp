#include "losses/clip_loss.h"

#include <cmath>

#include "core/error.h"
#include "ops/tone_map_tensor.h"

namespace ld {

using torch::Tensor;

namespace {

constexpr int64_t kLaplacianSide = 15;
constexpr double kLaplacianSigma = 1.5;

/// Of tone-mapped differences [N, 3, H, W], where the kernel lies inside.
Tensor edges(const Tensor& difference) {
  const int64_t height = difference.size(-2), width = difference.size(-1);
  if (height < kLaplacianSide || width < kLaplacianSide)
    fail("clip_loss.gradient: pictures of {}x{} pixels; expected at least {} a side, as many as its kernel",
         width, height, kLaplacianSide);
  const Tensor kernel = laplacian_of_gaussian(difference.scalar_type())
                            .to(difference.device())
                            .view({1, 1, kLaplacianSide, -1});
  return at::conv2d(difference.reshape({-1, 1, height, width}), kernel);
}

}  // namespace

std::vector<double> frame_weights(int64_t clip, double rise) {
  std::vector<double> weights;
  for (int64_t f = 0; f < clip; ++f) {
    const auto before_last = static_cast<double>(clip - 1 - f);
    weights.push_back(rise > 0 ? std::exp(-before_last * before_last / (2 * rise * rise)) : 1);
  }
  return weights;
}

Tensor laplacian_of_gaussian(torch::ScalarType type) {
  constexpr double kVariance = kLaplacianSigma * kLaplacianSigma;
  const Tensor at = torch::arange(kLaplacianSide, torch::kFloat64) - double(kLaplacianSide / 2);
  const Tensor square = at.square().unsqueeze(1) + at.square().unsqueeze(0);
  Tensor gaussian = at::exp(-square / (2 * kVariance));
  gaussian = gaussian / gaussian.sum();
  const Tensor kernel = gaussian * (square - 2 * kVariance) / (kVariance * kVariance);
  return (kernel - kernel.mean()).to(type);
}

ClipLoss make_clip_loss(const ClipLossConfig& config, Loss loss, bool in_powers) {
  if (config.is_plain())
    return [loss = std::move(loss)](const Tensor& denoised, const Tensor& reference, int64_t) {
      return loss(denoised, reference);
    };
  return [config, loss = std::move(loss), in_powers](const Tensor& denoised, const Tensor& reference,
                                                     int64_t clip) {
    if (clip < 1 || denoised.dim() != 4 || denoised.size(0) % clip != 0)
      fail("clip_loss: {} pictures are not whole clips of {}", denoised.size(0), clip);
    const Tensor d = denoised.unflatten(0, {-1, clip}),
                 r = reference.to(denoised.device()).unflatten(0, {-1, clip});
    const bool mapped = config.gradient > 0 || config.temporal > 0;
    // All terms but the spatial one see differences alone.
    const Tensor difference = !mapped ? Tensor() : in_powers ? d - r : tone_map(d) - tone_map(r);
    const std::vector<double> weights = frame_weights(clip, config.rise);
    Tensor sum;
    double weight = 0;
    for (int64_t f = 0; f < clip; ++f) {
      Tensor of_frame = config.spatial * loss(d.select(1, f), r.select(1, f));
      if (config.gradient > 0)
        of_frame = of_frame + config.gradient * edges(difference.select(1, f)).abs().mean();
      if (config.temporal > 0 && f > 0)
        of_frame =
            of_frame + config.temporal * (difference.select(1, f) - difference.select(1, f - 1)).abs().mean();
      of_frame = weights[size_t(f)] * of_frame;
      sum = sum.defined() ? sum + of_frame : of_frame;
      weight += weights[size_t(f)];
    }
    return sum / weight;
  };
}

}  // namespace ld
