#include "ops/kernel_splat.h"

#include "ops/composition.h"
#include "ops/expect_tensor.h"
#include "ops/finite_sources.h"
#include "ops/splat_driver.h"

namespace ld {
namespace {

using torch::Tensor;
using torch::autograd::AutogradContext;
using torch::autograd::variable_list;

FilterShape splat_shape(const Tensor& logits, const Tensor& values) {
  return {logits.size(1), expect_odd_kernel("kernel_splat", logits.size(2)), values.size(2), values.size(3),
          values.size(4)};
}

/// Writes a stretch of logits [B, N, K*K, H, W] to the rows of a tile.
void stage_logits(const FilterShape& shape, const float* picture, const Stretch& at, StagedRows& rows) {
  stage({picture + at.y * shape.width + at.x, shape.layers * shape.taps(), shape.plane()}, at.count,
        rows.row(0), rows.pitch());
}

class KernelSplat : public torch::autograd::Function<KernelSplat> {
 public:
  static Tensor forward(AutogradContext* context, const Tensor& logits, const Tensor& log_n,
                        const Tensor& values, bool joint, bool keep) {
    const FilterShape shape = splat_shape(logits, values);
    const int64_t batch = logits.size(0), layers = joint ? 1 : shape.layers;
    const auto empty = [&](int64_t planes) {
      return at::empty({batch, planes, shape.height, shape.width}, values.options());
    };
    const Tensor out = empty(layers * shape.channels);
    const Tensor largest = keep ? empty(layers) : Tensor(), inverse = keep ? empty(layers) : Tensor();
    const Pictures<float> z(logits), o(out), m(largest), i(inverse);
    const auto make_stage = [&] {
      return [&](int64_t b, const Stretch& at, SplatSourcesRow& sources) {
        stage_logits(shape, z[b], at, sources.logits);
      };
    };
    run_splat(shape, joint, batch, {Pictures<float>(log_n), Pictures<float>(values)}, make_stage,
              [&](int64_t b) {
                return SplatResult{o[b], m[b], i[b], shape.plane()};
              });
    if (keep) context->save_for_backward({logits, log_n, values, out, largest, inverse});
    context->saved_data["joint"] = joint;
    return joint ? out : out.view(values.sizes());
  }

  static variable_list backward(AutogradContext* context, variable_list gradients) {
    const variable_list saved = context->get_saved_variables();
    const Tensor &logits = saved[0], &log_n = saved[1], &values = saved[2], &out = saved[3],
                 &largest = saved[4], &inverse = saved[5];
    const bool joint = context->saved_data["joint"].toBool();
    const Tensor gradient = bounded_gradient(gradients[0], values);
    const FilterShape shape = splat_shape(logits, values);
    const int64_t batch = logits.size(0), layers = joint ? 1 : shape.layers;
    const Tensor logits_gradient = at::empty_like(logits), log_n_gradient = at::empty_like(log_n),
                 values_gradient = at::empty_like(values);
    const Pictures<float> z(logits), g(gradient), o(out), m(largest), i(inverse), gz(logits_gradient),
        gn(log_n_gradient), gv(values_gradient);
    const SplatInput input{Pictures<float>(log_n), Pictures<float>(values)};
    const int64_t pixels = stretch_pixels(2 * shape.layers * shape.taps(), shape.width);
    for (int64_t b = 0; b < batch; ++b) {
      SplatDestinations to(shape, joint);
      at::parallel_for(0, shape.height, 1, [&](int64_t begin, int64_t end) {
        for (int64_t y = begin; y < end; ++y)
          to.fill_row({o[b], m[b], i[b], shape.plane()}, g[b], shape.width, layers, y);
      });
      at::parallel_for(0, shape.height, 1, [&](int64_t begin, int64_t end) {
        SplatSourcesRow sources(shape, pixels);
        SplatGradientRow row(shape, pixels);
        for_each_stretch(shape, pixels, begin, end, [&](const Stretch& at) {
          stage_logits(shape, z[b], at, sources.logits);
          stage_values(shape, input, b, at, sources);
          splat_stretch_backward(shape, sources, to, at, row);
          const int64_t offset = at.y * shape.width + at.x;
          const auto write = [&](const StagedRows& from, float* planes) {
            unstage(from.row(0), from.pitch(), from.rows(), at.count, planes + offset, shape.plane());
          };
          write(row.logits, gz[b]);
          write(row.log_n, gn[b]);
          write(row.values, gv[b]);
        });
      });
    }
    return {logits_gradient, log_n_gradient, values_gradient, Tensor(), Tensor()};
  }
};

Tensor splat(const char* name, const Tensor& logits, const Tensor& log_n, const Tensor& values, bool joint) {
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
  const FiniteSources sources = finite_sources(log_n, values);
  if (runs_composed(logits))
    return unscaled(composed::kernel_splat(logits, sources.log_n, sources.values, joint), sources);
  const bool differentiable = at::GradMode::is_enabled() &&
                              (logits.requires_grad() || log_n.requires_grad() || values.requires_grad());
  return unscaled(KernelSplat::apply(logits.contiguous(), sources.log_n.contiguous(),
                                     sources.values.contiguous(), joint, differentiable),
                  sources);
}

}  // namespace

Tensor kernel_splat(const Tensor& logits, const Tensor& log_n, const Tensor& values) {
  return splat("kernel_splat", logits, log_n, values, /*joint=*/false);
}

Tensor kernel_splat_joint(const Tensor& logits, const Tensor& log_n, const Tensor& values) {
  return splat("kernel_splat_joint", logits, log_n, values, /*joint=*/true);
}

}  // namespace ld
