#include "ops/kernel_gather.h"

#include <memory>

#include "ops/composition.h"
#include "ops/expect_tensor.h"
#include "ops/finite_sources.h"
#include "ops/gather_driver.h"

namespace ld {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

constexpr int64_t kStripRows =
    32;  // of a partial sum of the values' gradient; fixed, so threads change no bit

FilterShape gather_shape(const Tensor& logits, const Tensor& values) {
  return {1, expect_odd_kernel("kernel_gather", logits.size(1)), values.size(1), values.size(2),
          values.size(3)};
}

void stage_planes(const FilterShape& shape, const float* picture, const Stretch& at, StagedRows& rows) {
  stage({picture + at.y * shape.width + at.x, rows.rows(), shape.plane()}, at.count, rows.row(0),
        rows.pitch());
}

class KernelGather : public torch::autograd::Function<KernelGather> {
 public:
  static Tensor forward(AutogradContext* context, const Tensor& logits, const Tensor& log_n,
                        const Tensor& values, bool keep) {
    const FilterShape shape = gather_shape(logits, values);
    const Tensor out = at::empty_like(values);
    const Tensor totals =
        keep ? at::empty({values.size(0), 2, shape.height, shape.width}, values.options()) : Tensor();
    const Pictures<float> z(logits);
    run_gather(
        shape, values.size(0), Pictures<float>(log_n), Pictures<float>(values),
        [&] {
          return [&](int64_t b, const Stretch& at, StagedRows& rows) { stage_planes(shape, z[b], at, rows); };
        },
        Pictures<float>(out), Pictures<float>(totals));
    if (keep) context->save_for_backward({logits, log_n, values, out, totals});
    return out;
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const Tensor &logits = saved[0], &values = saved[2];
    const Tensor gradient = bounded_gradient(gradients[0], values);
    const FilterShape shape = gather_shape(logits, values);
    const Tensor logits_gradient = at::empty_like(logits);
    Tensor values_gradient;
    if (values.requires_grad()) values_gradient = at::empty_like(values);
    const Pictures<float> z(logits), n(saved[1]), v(values), o(saved[3]), t(saved[4]), g(gradient),
        gz(logits_gradient), gv(values_gradient);
    const int64_t strips = (shape.height + kStripRows - 1) / kStripRows;
    const int64_t pixels = stretch_pixels(2 * shape.taps(), shape.width);
    for (int64_t b = 0; b < values.size(0); ++b) {
      const GatherSources sources = gather_sources(shape, n[b], v[b]);
      std::vector<std::unique_ptr<GatherStrip>> sums{size_t(strips)};
      at::parallel_for(0, strips, 1, [&](int64_t begin, int64_t end) {
        GatherGradientRow row(shape, pixels);
        for (int64_t s = begin; s < end; ++s) {
          const int64_t first = s * kStripRows, last = std::min(first + kStripRows, shape.height);
          if (gv[b] != nullptr) sums[size_t(s)] = std::make_unique<GatherStrip>(shape, first, last);
          for (int64_t y = first; y < last; ++y)
            for (int64_t x = 0; x < shape.width; x += pixels) {
              const Stretch at{y, x, std::min(pixels, shape.width - x)};
              stage_planes(shape, z[b], at, row.logits);
              stage_planes(shape, t[b], at, row.totals);
              stage_planes(shape, o[b], at, row.out);
              stage_planes(shape, g[b], at, row.gradient);
              row.gradient.fill_behind(at.count, 0.0f);
              gather_stretch_backward(shape, sources, at, row, sums[size_t(s)].get());
              unstage(row.logits_gradient.row(0), row.logits_gradient.pitch(), shape.taps(), at.count,
                      gz[b] + y * shape.width + x, shape.plane());
            }
        }
      });
      if (gv[b] != nullptr) add_strips(shape, sums, gv[b]);
    }
    return {logits_gradient, Tensor(), values_gradient, Tensor()};
  }

 private:
  /// values_gradient [C][H][W] = the sum of the strips, in their order.
  static void add_strips(const FilterShape& shape, const std::vector<std::unique_ptr<GatherStrip>>& strips,
                         float* values_gradient) {
    at::parallel_for(0, shape.channels * shape.height, 16, [&](int64_t begin, int64_t end) {
      for (int64_t i = begin; i < end; ++i) {
        float* to = values_gradient + i * shape.width;
        std::fill_n(to, shape.width, 0.0f);
        for (const auto& strip : strips) {
          if (!strip->holds(i % shape.height)) continue;
          const float* from = strip->row(i / shape.height, i % shape.height);
          for (int64_t x = 0; x < shape.width; ++x) to[x] += from[x];
        }
      }
    });
  }
};

}  // namespace

Tensor kernel_gather(const Tensor& logits, const Tensor& log_n, const Tensor& values) {
  const auto type = floating_type("kernel_gather: logits", logits);
  expect_tensor("kernel_gather: logits", "[B, K*K, H, W]", logits, {kAnySize, kAnySize, kAnySize, kAnySize},
                type);
  expect_odd_kernel("kernel_gather", logits.size(1));
  const int64_t batch = logits.size(0), height = logits.size(2), width = logits.size(3);
  expect_tensor("kernel_gather: log_n", "[B, H, W]", log_n, {batch, height, width}, type);
  expect_tensor("kernel_gather: values", "[B, C, H, W]", values, {batch, kAnySize, height, width}, type);
  const FiniteSources sources = finite_sources(log_n.detach(), values);
  if (runs_composed(logits))
    return unscaled(composed::kernel_gather(logits, sources.log_n, sources.values), sources);
  const bool differentiable =
      at::GradMode::is_enabled() && (logits.requires_grad() || values.requires_grad());
  return unscaled(KernelGather::apply(logits.contiguous(), sources.log_n.contiguous(),
                                      sources.values.contiguous(), differentiable),
                  sources);
}

}  // namespace ld
