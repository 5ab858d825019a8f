#include "ops/weighted_sum.h"

#include <ATen/Parallel.h>

#include "ops/expect_tensor.h"
#include "ops/pictures.h"
#include "ops/sum_loops.h"

namespace ld {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

constexpr int64_t kTile = 512;  // pixels: a tile's planes of one sample stay in the first two cache levels

SumShape sum_shape(const Tensor& weights, const Tensor& values) {
  return {weights.size(1), weights.size(2), values.size(2), values.size(3) * values.size(4)};
}

/// Calls body(picture, begin, end) for every tile of pixels of every picture of the batch.
template <class Body>
void for_each_tile(int64_t batch, int64_t plane, Body body) {
  const int64_t tiles = (plane + kTile - 1) / kTile;
  at::parallel_for(0, batch * tiles, 1, [&](int64_t first, int64_t last) {
    for (int64_t i = first; i < last; ++i) {
      const int64_t begin = i % tiles * kTile;
      body(i / tiles, begin, std::min(begin + kTile, plane));
    }
  });
}

class WeightedSum : public torch::autograd::Function<WeightedSum> {
 public:
  static Tensor forward(AutogradContext* context, const Tensor& weights, const Tensor& values) {
    const Tensor w = weights.contiguous(), v = values.contiguous();
    context->save_for_backward({w, v});
    if (!v.is_cpu()) return (w.unsqueeze(3) * v.unsqueeze(2)).sum(1);
    const SumShape shape = sum_shape(w, v);
    Tensor out = at::empty({w.size(0), w.size(2), v.size(2), v.size(3), v.size(4)}, v.options());
    AT_DISPATCH_FLOATING_TYPES(v.scalar_type(), "weighted_sum", [&] {
      const Pictures<scalar_t> weight_data(w), value_data(v), out_data(out);
      for_each_tile(w.size(0), shape.plane, [&](int64_t b, int64_t begin, int64_t end) {
        sum_samples(shape, weight_data[b], value_data[b], out_data[b], begin, end);
      });
    });
    return out;
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const Tensor &w = saved[0], &v = saved[1];
    const Tensor gradient = gradients[0].contiguous();
    Tensor w_gradient, v_gradient;
    if (!v.is_cpu()) {
      if (context->needs_input_grad(0)) w_gradient = composed_weights_gradient(gradient, v);
      if (context->needs_input_grad(1)) v_gradient = (w.unsqueeze(3) * gradient.unsqueeze(1)).sum(2);
      return {w_gradient, v_gradient};
    }
    const SumShape shape = sum_shape(w, v);
    if (context->needs_input_grad(0)) w_gradient = at::empty_like(w);
    if (context->needs_input_grad(1)) v_gradient = at::empty_like(v);
    AT_DISPATCH_FLOATING_TYPES(v.scalar_type(), "weighted_sum_backward", [&] {
      const Pictures<scalar_t> w_data(w), v_data(v), g(gradient), w_out(w_gradient), v_out(v_gradient);
      for_each_tile(w.size(0), shape.plane, [&](int64_t b, int64_t begin, int64_t end) {
        if (w_gradient.defined()) sum_samples_weights_gradient(shape, g[b], v_data[b], w_out[b], begin, end);
        if (v_gradient.defined()) sum_samples_values_gradient(shape, g[b], w_data[b], v_out[b], begin, end);
      });
    });
    return {w_gradient, v_gradient};
  }

 private:
  static Tensor composed_weights_gradient(const Tensor& gradient, const Tensor& values) {
    const double bound =
        values.scalar_type() == torch::kFloat32 ? double(kLargestTerm<float>) : kLargestTerm<double>;
    return (gradient.unsqueeze(1) * values.unsqueeze(2)).clamp(-bound, bound).sum(3);
  }
};

}  // namespace

Tensor weighted_sum(const Tensor& weights, const Tensor& values) {
  const auto type = floating_type("weighted_sum: values", values);
  expect_tensor("weighted_sum: values", "[B, S, C, H, W]", values,
                {kAnySize, kAnySize, kAnySize, kAnySize, kAnySize}, type);
  expect_tensor("weighted_sum: weights", "[B, S, N, H, W]", weights,
                {values.size(0), values.size(1), kAnySize, values.size(3), values.size(4)}, type);
  return WeightedSum::apply(weights, values);
}

Tensor masked_mean(const Tensor& values, const Tensor& valid) {
  const auto type = floating_type("masked_mean: values", values);
  expect_tensor("masked_mean: values", "[B, S, C, H, W]", values,
                {kAnySize, kAnySize, kAnySize, kAnySize, kAnySize}, type);
  expect_tensor("masked_mean: valid", "[B, S, 1, H, W]", valid,
                {values.size(0), values.size(1), 1, values.size(3), values.size(4)}, type);
  const Tensor mask = valid.detach().ne(0).to(type);
  return weighted_sum(mask / mask.sum(1, /*keepdim=*/true).clamp_min(1), values).squeeze(1);
}

}  // namespace ld
