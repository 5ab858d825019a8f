#include "ops/tone_map_tensor.h"

#include <ATen/Parallel.h>

#include "core/tone_map.h"
#include "ops/expect_tensor.h"

namespace ld {
namespace {

using torch::Tensor;

constexpr int64_t kGrain = 4096;  // elements a thread takes at once: some 100 microseconds of pow()

/// out[i] = function(in[i]) over contiguous tensors, in parallel.
template <class Function>
Tensor map(const Tensor& in, Function function) {
  const Tensor source = in.contiguous();
  Tensor out = at::empty_like(source);
  AT_DISPATCH_FLOATING_TYPES(source.scalar_type(), "tone_map", [&] {
    const scalar_t* from = source.data_ptr<scalar_t>();
    scalar_t* to = out.data_ptr<scalar_t>();
    at::parallel_for(0, source.numel(), kGrain, [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i) to[i] = function(from[i]);
    });
  });
  return out;
}

/// The same of core/tone_map.h on other devices than the CPU; y = log(1 + x), of x where it is above 0.
constexpr double kLinear = 0.0031308;

Tensor composed_tone_map(const Tensor& x) {
  const Tensor y = x.clamp_min(0).log1p();
  return at::where(y.le(kLinear), 12.92 * y, 1.055 * y.pow(1 / 2.4) - 0.055)
      .masked_fill(x.gt(0).logical_not(), 0);
}

Tensor composed_tone_map_slope(const Tensor& x) {
  const Tensor y = x.clamp_min(0).log1p();
  const Tensor outer = (1.055 / 2.4 * y.pow(1 / 2.4 - 1)).masked_fill(y.le(kLinear), 12.92);
  return (outer / (1 + x)).masked_fill(x.gt(0).logical_not(), 12.92);
}

class ToneMap : public torch::autograd::Function<ToneMap> {
 public:
  static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& linear) {
    context->save_for_backward({linear});
    return linear.is_cpu() ? map(linear, [](auto x) { return tone_map(x); }) : composed_tone_map(linear);
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::variable_list gradient) {
    return {gradient[0] * tone_map_slope(context->get_saved_variables()[0])};
  }
};

/// tone_map_inverse() of core/tone_map.h on other devices than the CPU.
Tensor composed_inverse(const Tensor& y) {
  const Tensor within = y.clamp(0, 3);
  const Tensor linear = at::where(within.le(0.04045), within / 12.92, ((within + 0.055) / 1.055).pow(2.4));
  return linear.expm1().clamp_max(65504).masked_fill(y.gt(0).logical_not(), 0);
}

class ToneMapInverse : public torch::autograd::Function<ToneMapInverse> {
 public:
  static Tensor forward(torch::autograd::AutogradContext* context, const Tensor& mapped) {
    const Tensor linear =
        mapped.is_cpu() ? map(mapped, [](auto y) { return tone_map_inverse(y); }) : composed_inverse(mapped);
    context->save_for_backward({linear});
    return linear;
  }

  static torch::autograd::variable_list backward(torch::autograd::AutogradContext* context,
                                                 torch::autograd::variable_list gradient) {
    return {gradient[0] / tone_map_slope(context->get_saved_variables()[0])};
  }
};

}  // namespace

Tensor tone_map_inverse(const Tensor& mapped) {
  floating_type("tone_map_inverse: the image", mapped);
  return ToneMapInverse::apply(mapped);
}

Tensor tone_map(const Tensor& linear) {
  floating_type("tone_map: the image", linear);
  return ToneMap::apply(linear);
}

Tensor tone_map_slope(const Tensor& linear) {
  floating_type("tone_map_slope: the image", linear);
  const Tensor x = linear.detach();
  return x.is_cpu() ? map(x, [](auto value) { return tone_map_slope(value); }) : composed_tone_map_slope(x);
}

}  // namespace ld
