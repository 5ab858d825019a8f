#include "ops/composition.h"

#include <cmath>
#include <limits>

#include "ops/expect_tensor.h"
#include "ops/kernels/constants.h"

namespace ld {
namespace {

using torch::Tensor;

/// The lowest value that logits count as: differences and sums of a few of them stay finite.
double lowest_logit(torch::ScalarType type) {
  return type == torch::kFloat32 ? double(kLowestLogit) : std::numeric_limits<double>::lowest() / 4;
}

/// Logits within their range, NaN as the lowest.
Tensor bounded(const Tensor& logits) {
  const double lowest = lowest_logit(logits.scalar_type());
  return logits.masked_fill(logits.isnan(), lowest).clamp(lowest, -lowest);
}

/// What exponents are compared with: the largest of them, and 0 where all are -inf, -inf - -inf being NaN.
Tensor comparable(const Tensor& largest) {
  return largest.masked_fill(largest.eq(-kInfinity), 0);
}

/// Planes [..., H, W] with a margin, of which every shift is a view.
struct Shifted {
  Tensor padded;
  int64_t radius, height, width;
  Shifted(const Tensor& planes, int64_t kernel, double margin)
      : padded(at::constant_pad_nd(planes, {kernel / 2, kernel / 2, kernel / 2, kernel / 2}, margin)),
        radius(kernel / 2),
        height(planes.size(-2)),
        width(planes.size(-1)) {}
  /// At pixel (y, x) what the planes have at (y + dy, x + dx).
  Tensor at_offset(int64_t dy, int64_t dx) const {
    return padded.narrow(-2, radius + dy, height).narrow(-1, radius + dx, width);
  }
};

struct Tap {
  int64_t index, dy, dx;
};

std::vector<Tap> taps(int64_t kernel) {
  std::vector<Tap> taps;
  for (int64_t i = 0; i < kernel * kernel; ++i)
    taps.push_back({i, i / kernel - kernel / 2, i % kernel - kernel / 2});
  return taps;
}

std::vector<Tensor> planes_of(const Tensor& taps, int64_t axis) {
  if (ComposedOperators::current().value_or(Taps::at_once) == Taps::at_once) return taps.unbind(axis);
  std::vector<Tensor> planes;
  for (int64_t i = 0; i < taps.size(axis); ++i) planes.push_back(taps.select(axis, i));
  return planes;
}

int64_t kernel_size(int64_t count) {
  return std::lround(std::sqrt(double(count)));
}

}  // namespace

bool runs_composed(const Tensor& tensor) {
  return composed_operators() || tensor.scalar_type() != torch::kFloat32 || !tensor.device().is_cpu();
}

namespace composed {

Tensor fully_connected(const Tensor& x, const Tensor& shared, const FullyConnectedWeights& network,
                       bool activate_last) {
  const int64_t batch = x.size(0), samples = x.size(1), height = x.size(3), width = x.size(4);
  Tensor a = x;
  if (shared.defined())
    a = at::cat({x, shared.unsqueeze(1).expand({batch, samples, shared.size(1), height, width})}, 2);
  a = a.flatten(0, 1);
  for (size_t i = 0; i < network.weights.size(); ++i) {
    a = at::conv2d(a, network.weights[i].unsqueeze(2).unsqueeze(3), network.biases[i]);
    if (i + 1 < network.weights.size() || activate_last) a = at::leaky_relu(a, kLeakySlope);
  }
  if (network.bound > 0) a = at::sign(a) * (network.bound - network.bound / (1 + a.abs() / network.bound));
  return a.unflatten(0, {batch, samples});
}

Tensor kernel_splat(const Tensor& logits, const Tensor& log_n, const Tensor& values, bool joint) {
  const int64_t kernel = kernel_size(logits.size(2));
  const Tensor z = bounded(logits);
  const Tensor largest = std::get<0>(z.flatten(1, 2).max(1));  // m_p [B, H, W]
  const Tensor e =
      (z - largest.unsqueeze(1).unsqueeze(2)).clamp_min(lowest_logit(z.scalar_type())) + log_n.unsqueeze(2);
  std::vector<Tensor> exponents = planes_of(e, 2);
  for (const Tap& tap : taps(kernel)) {
    Tensor& plane = exponents[size_t(tap.index)];
    plane = Shifted(plane, kernel, -kInfinity).at_offset(-tap.dy, -tap.dx);
  }
  const Shifted sources(values, kernel, 0);

  // The largest exponent that arrives cancels between numerator and denominator: no gradient flows through
  // it.
  Tensor top;
  {
    const at::NoGradGuard constant;
    for (const Tensor& arriving : exponents) top = top.defined() ? at::maximum(top, arriving) : arriving;
    if (joint) top = top.amax(1, /*keepdim=*/true);
    top = comparable(top);
  }
  Tensor numerator, denominator;
  for (const Tap& tap : taps(kernel)) {
    const Tensor weight = (exponents[size_t(tap.index)] - top).exp().unsqueeze(2);
    const Tensor product = weight * sources.at_offset(-tap.dy, -tap.dx);
    numerator = numerator.defined() ? numerator + product : product;
    denominator = denominator.defined() ? denominator + weight : weight;
  }
  if (joint) {
    numerator = numerator.sum(1);
    denominator = denominator.sum(1);
  }
  return numerator / denominator.masked_fill(denominator.eq(0), 1);
}

Tensor kernel_gather(const Tensor& logits, const Tensor& log_n, const Tensor& values) {
  const int64_t kernel = kernel_size(logits.size(1));
  const std::vector<Tensor> z = planes_of(bounded(logits), 1);
  const Shifted given(log_n, kernel, -kInfinity), sources(values, kernel, 0);
  Tensor top;
  {
    const at::NoGradGuard constant;
    for (const Tap& tap : taps(kernel)) {
      const Tensor arriving = z[size_t(tap.index)] + given.at_offset(tap.dy, tap.dx);
      top = top.defined() ? at::maximum(top, arriving) : arriving;
    }
    top = comparable(top);
  }
  Tensor numerator, denominator;
  for (const Tap& tap : taps(kernel)) {
    const Tensor weight = (z[size_t(tap.index)] - top + given.at_offset(tap.dy, tap.dx)).exp().unsqueeze(1);
    const Tensor product = weight * sources.at_offset(tap.dy, tap.dx);
    numerator = numerator.defined() ? numerator + product : product;
    denominator = denominator.defined() ? denominator + weight : weight;
  }
  return numerator / denominator.masked_fill(denominator.eq(0), 1);
}

Partition partition(const Tensor& logits, const Tensor& valid, const Tensor& radiance,
                    const Tensor& embedding, Compositing compositing) {
  const int64_t samples = logits.size(1), layers = logits.size(2);
  const Tensor finite = radiance.isfinite().all(2, /*keepdim=*/true);
  const Tensor mask = valid.ne(0).logical_and(finite);
  const Tensor none = mask.any(1, /*keepdim=*/true).logical_not();  // [B, 1, 1, H, W]
  // Where no sample is valid all are counted, so that nothing divides 0 by 0, and the results are masked at
  // the end.
  const Tensor counted = mask.logical_or(none);
  const Tensor count = counted.sum(1).to(logits.scalar_type());  // [B, 1, H, W]
  const Tensor log_w = at::log_softmax(bounded(logits), 2)
                           .clamp_min(lowest_logit(logits.scalar_type()))
                           .masked_fill(counted.logical_not(), -kInfinity);

  std::vector<Tensor> log_n, share, transmittance;
  for (int64_t l = 0; l < layers; ++l) {
    // What each sample puts into layer l and, for alpha, those behind it, relative to n_l: opacity and
    // transmittance come from one softmax, so they add up to 1 however large the logits (a difference of log
    // n would not).
    const int64_t depth = compositing == Compositing::alpha ? layers - l : 1;
    const Tensor behind = log_w.narrow(2, l, depth).flatten(1, 2);  // [B, S * depth, H, W]
    const Tensor q = at::softmax(behind, 1).unflatten(1, {samples, depth});
    share.push_back(q.narrow(2, 0, 1));  // w_s^l / (S n_l)
    transmittance.push_back(q.narrow(2, 1, depth - 1).sum({1, 2}));
    const bool front = l == 0 && compositing == Compositing::alpha;  // n_0 = 1
    log_n.push_back(front ? at::zeros_like(count) : at::logsumexp(behind, 1, true) - count.log());
  }

  const Tensor shares = at::cat(share, 2).masked_fill(none, 0);
  const Tensor weights = log_w.exp().masked_fill(none, 0) / count.unsqueeze(1);
  const auto sum = [](const Tensor& w, const Tensor& v) {
    return at::stack(
        [&] {
          std::vector<Tensor> sums;
          for (int64_t l = 0; l < w.size(2); ++l) sums.push_back((w.narrow(2, l, 1) * v).sum(1));
          return sums;
        }(),
        1);
  };
  Partition result;
  result.log_n = at::cat(log_n, 1).masked_fill(none.squeeze(1), -kInfinity);
  result.radiance = sum(shares, radiance.masked_fill(finite.logical_not(), 0));
  result.opacity = shares.sum(1).unsqueeze(2);
  if (compositing == Compositing::alpha)
    result.transmittance = at::stack(transmittance, 1).unsqueeze(2).masked_fill(none, 0);
  result.embedding = sum(weights, embedding);
  return result;
}

}  // namespace composed
}  // namespace ld
