#include "ops/finite_sources.h"

#include <cmath>
#include <limits>

#include "ops/expect_tensor.h"
#include "ops/kernels/constants.h"

namespace ld {

using torch::Tensor;

namespace {

// Above this the 31 * 31 taps of 1024 layers of float32 values could overflow a sum (10^38 / 10^6); a scene
// that has no such value is not touched, so that scaling it by a power of two changes no bit.
constexpr double kLargestValue = 1e32;
// A gradient times a value must stay below what the sum over the channels and taps of a kernel can hold.
constexpr double kLargestProduct = 1e33;
constexpr double kHarmlessValue = 1e6;  // beyond half's range by far; gradients have 27 orders left

}  // namespace

FiniteSources finite_sources(const Tensor& log_n, const Tensor& values) {
  FiniteSources sources{log_n, values, 1};
  if (values.numel() == 0) return sources;
  const auto [low, high] = at::aminmax(values.detach());  // NaN passes through
  double largest = std::max(-low.item<double>(), high.item<double>());
  const double highest_log_n = log_n.detach().max().item<double>();
  if (!(largest < kInfinity) || std::isnan(low.item<double>()) || !(highest_log_n < kInfinity)) {
    const Tensor good = values.detach().isfinite().all(-3).logical_and(log_n.detach().lt(kInfinity));
    sources.log_n = log_n.masked_fill(good.logical_not(), -kInfinity);
    sources.values = values.masked_fill(good.logical_not().unsqueeze(-3), 0);
    largest = sources.values.detach().abs().max().item<double>();
  }
  if (largest > kLargestValue && values.scalar_type() == torch::kFloat32) {
    sources.scale = kOverflowScale;
    sources.values = sources.values * kOverflowScale;
  }
  return sources;
}

Tensor unscaled(const Tensor& filtered, const FiniteSources& sources) {
  return sources.scale == 1 ? filtered : filtered / sources.scale;
}

Tensor bounded_gradient(const Tensor& gradient, const Tensor& values) {
  const Tensor contiguous = gradient.contiguous();
  if (values.numel() == 0) return contiguous;
  const auto [low, high] = at::aminmax(values.detach());
  const double largest = std::max(-low.item<double>(), high.item<double>());
  if (largest < kHarmlessValue) return contiguous;
  const double limit = kLargestProduct / largest;
  return contiguous.clamp(-limit, limit);
}

}  // namespace ld
