#include "ops/kernel_splat.h"

#include <ATen/Parallel.h>

#include <cmath>

#include "core/error.h"
#include "ops/check.h"
#include "ops/composition.h"
#include "ops/finite_sources.h"
#include "ops/pictures.h"
#include "ops/splat_loops.h"

namespace ld {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

constexpr int64_t kStretch = 256;  // pixels: 17x17 weights of a stretch are 300 kB, within the L2 cache

SplatShape splat_shape(const Tensor& logits, const Tensor& values) {
  const auto kernel = std::lround(std::sqrt(double(logits.size(2))));
  return {logits.size(1), kernel, values.size(2), values.size(3), values.size(4)};
}

/// Calls body(picture, layer, stretch) for all stretches of all rows, on all threads.
template <class Body>
void for_each_stretch(int64_t batch, int64_t layers, const SplatShape& shape, const Body& body) {
  const int64_t stretches = (shape.width + kStretch - 1) / kStretch;
  at::parallel_for(0, batch * layers * shape.height * stretches, 1, [&](int64_t first, int64_t last) {
    for (int64_t i = first; i < last; ++i) {
      const int64_t begin = i % stretches * kStretch, row = i / stretches;
      const Stretch stretch{row % shape.height, begin, std::min(begin + kStretch, shape.width)};
      body(row / shape.height / layers, row / shape.height % layers, stretch);
    }
  });
}

class KernelSplat : public torch::autograd::Function<KernelSplat> {
 public:
  static Tensor forward(AutogradContext* context, const Tensor& logits_in, const Tensor& log_n_in,
                        const Tensor& values_in, bool keep) {
    const Tensor logits = logits_in.contiguous(), log_n = log_n_in.contiguous(),
                 values = values_in.contiguous();
    const SplatShape shape = splat_shape(logits, values);
    const int64_t batch = logits.size(0);
    const auto type = logits.scalar_type();
    const Tensor maximum = at::empty({batch, shape.height, shape.width}, logits.options());
    const Tensor argmax =
        at::empty({batch, shape.height, shape.width}, logits.options().dtype(torch::kInt32));
    const Tensor probabilities = keep ? at::empty_like(logits) : Tensor();
    const Tensor out = at::empty_like(values);
    AT_DISPATCH_FLOATING_TYPES(type, "kernel_splat", [&] {
      const Pictures<scalar_t> z(logits), m(maximum), n(log_n), v(values), p(probabilities), o(out);
      const Pictures<int32_t> a(argmax);
      for_each_stretch(batch, 1, shape, [&](int64_t b, int64_t, const Stretch& at) {
        splat_maximum(shape, z[b], m[b], a[b], at);
      });
      for_each_stretch(batch, shape.layers, shape, [&](int64_t b, int64_t layer, const Stretch& at) {
        at::AutoDispatchBelowADInplaceOrView
            plain;  // worker threads do not inherit the caller's autograd state
        Tensor weights = at::empty({shape.taps(), at.count()}, type), row = at::empty({at.count()}, type);
        auto* w = weights.data_ptr<scalar_t>();
        auto* r = row.data_ptr<scalar_t>();
        splat_exponents(shape, layer, z[b], m[b], n[b], w, r, at);
        at::exp_(weights);  // LibTorch's is vectorised for the machine it runs on
        splat_values(shape, layer, w, v[b], p[b], o[b], r, at);
      });
    });
    if (keep) context->save_for_backward({probabilities, values, out, argmax});
    return out;
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const Tensor &probabilities = saved[0], &values = saved[1], &out = saved[2], &argmax = saved[3];
    const Tensor gradient = gradients[0].contiguous();
    const SplatShape shape = splat_shape(probabilities, values);
    const Tensor logits_gradient = at::empty_like(probabilities), values_gradient = at::empty_like(values);
    const Tensor log_n_gradient =
        at::empty({values.size(0), shape.layers, shape.height, shape.width}, values.options());
    AT_DISPATCH_FLOATING_TYPES(values.scalar_type(), "kernel_splat_backward", [&] {
      const Pictures<scalar_t> p(probabilities), v(values), o(out), g(gradient), gz(logits_gradient),
          gn(log_n_gradient), gv(values_gradient);
      const Pictures<int32_t> a(argmax);
      at::parallel_for(0, values.size(0) * shape.height, 1, [&](int64_t first, int64_t last) {
        std::vector<scalar_t> scratch(static_cast<size_t>(2 * shape.width));
        for (int64_t i = first; i < last; ++i) {
          const int64_t b = i / shape.height;
          splat_backward(shape, p[b], v[b], o[b], g[b], a[b], gz[b], gn[b], gv[b], scratch.data(),
                         i % shape.height);
        }
      });
    });
    return {logits_gradient, log_n_gradient, values_gradient, Tensor()};
  }
};

/// The checks that both entries share.
void check(const char* name, const Tensor& logits, const Tensor& log_n, const Tensor& values) {
  const std::string op = name;
  const auto type = floating_type((op + ": logits").c_str(), logits);
  expect_tensor((op + ": logits").c_str(), "[B, N, K*K, H, W]", logits,
                {kAnySize, kAnySize, kAnySize, kAnySize, kAnySize}, type);
  expect_odd_kernel(name, logits.size(2));
  const int64_t batch = logits.size(0), layers = logits.size(1), height = logits.size(3),
                width = logits.size(4);
  expect_tensor((op + ": log_n").c_str(), "[B, N, H, W]", log_n, {batch, layers, height, width}, type);
  expect_tensor((op + ": values").c_str(), "[B, N, C, H, W]", values,
                {batch, layers, kAnySize, height, width}, type);
}

}  // namespace

Tensor kernel_splat(const Tensor& logits, const Tensor& log_n, const Tensor& values) {
  check("kernel_splat", logits, log_n, values);
  const SplatSources sources = finite_sources(log_n, values);
  if (runs_composed(logits))
    return composed::kernel_splat(logits, sources.log_n, sources.values, /*joint=*/false) / sources.scale;
  const bool differentiable = at::GradMode::is_enabled() &&
                              (logits.requires_grad() || log_n.requires_grad() || values.requires_grad());
  return KernelSplat::apply(logits, sources.log_n, sources.values, differentiable) / sources.scale;
}

Tensor kernel_splat_joint(const Tensor& logits, const Tensor& log_n, const Tensor& values) {
  check("kernel_splat_joint", logits, log_n, values);
  const SplatSources sources = finite_sources(log_n, values);
  return composed::kernel_splat(logits, sources.log_n, sources.values, /*joint=*/true) / sources.scale;
}

}  // namespace ld
