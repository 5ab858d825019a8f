#include "ops/generated_filter.h"

#include <algorithm>

#include "core/error.h"
#include "ops/composition.h"
#include "ops/expect_tensor.h"
#include "ops/finite_sources.h"
#include "ops/gather_driver.h"
#include "ops/kernel_gather.h"
#include "ops/kernel_splat.h"
#include "ops/network_tiles.h"
#include "ops/splat_driver.h"

namespace ld {
namespace {

using torch::Tensor;

constexpr int64_t kLogitBytes = int64_t(256) << 20;  // of kernel logits that exist at a time

Tensor rows(const Tensor& t, int64_t first, int64_t last) {
  return t.narrow(t.dim() - 2, first, last - first);
}

/// Calls filter(logits, log_n, values) for strips of rows, widened by the reach of the kernel, whose logits
/// fit in kLogitBytes; for all rows at once where a gradient is kept.
template <class Filter>
Tensor in_strips(const FullyConnectedWeights& generator, const Tensor& x, const Tensor& shared,
                 const Tensor& log_n, const Tensor& values, const Filter& filter) {
  const int64_t taps = generator.weights.back().size(0), height = x.size(3);
  const int64_t radius = expect_odd_kernel("generated filter", taps) / 2;
  const int64_t row_bytes =
      std::max<int64_t>(x.size(0) * x.size(1) * taps * x.size(4) * int64_t(x.element_size()), 1);
  const int64_t step = at::GradMode::is_enabled() ? height : std::max<int64_t>(kLogitBytes / row_bytes, 16);
  std::vector<Tensor> strips;
  for (int64_t begin = 0; begin < height; begin += step) {
    const int64_t end = std::min(begin + step, height);
    const int64_t first = std::max<int64_t>(begin - radius, 0), last = std::min(end + radius, height);
    const Tensor logits = fully_connected(rows(x, first, last), rows(shared, first, last), generator, false);
    strips.push_back(rows(filter(logits, rows(log_n, first, last), rows(values, first, last)), begin - first,
                          end - first));
  }
  return strips.size() == 1 ? strips[0] : at::cat(strips, strips[0].dim() - 2);
}

/// A thread's kernel generator: writes the logits of a stretch straight to where the filter reads them.
class StretchGenerator {
 public:
  StretchGenerator(const TileNetwork& network, const FilterShape& shape, const Tensor& x,
                   const Tensor& shared)
      : network_(network),
        shape_(shape),
        x_(x),
        shared_(shared),
        scratch_(network.make_scratch(stretch_pixels(shape.layers * shape.taps(), shape.width), false)) {}

  void operator()(int64_t b, const Stretch& at, StagedRows& logits) {
    const int64_t offset = at.y * shape_.width + at.x, inputs = network_.x_inputs();
    stage({shared_[b] + offset, network_.shared_inputs(), shape_.plane()}, at.count, scratch_.shared,
          scratch_.pitch);
    network_.begin_tile(scratch_, at.count);
    for (int64_t l = 0; l < shape_.layers; ++l) {
      stage({x_[b] + l * inputs * shape_.plane() + offset, inputs, shape_.plane()}, at.count, scratch_.x,
            scratch_.pitch);
      network_.forward(scratch_, at.count, {logits.row(l * shape_.taps()), logits.pitch()});
    }
  }

 private:
  const TileNetwork& network_;
  FilterShape shape_;
  Pictures<float> x_, shared_;
  TileNetwork::Scratch scratch_;
};

/// Whether the fused kernels may run: they keep nothing for a backward pass.
bool runs_fused(const Tensor& x) {
  return !runs_composed(x) && !at::GradMode::is_enabled();
}

/// Checks what the strips of the unfused path would check in kernel_splat and fully_connected.
void check(const FullyConnectedWeights& generator, const Tensor& x, const Tensor& shared, const Tensor& log_n,
           const Tensor& values) {
  const auto type = floating_type("generated filter: x", x);
  if (generator.weights.empty() || generator.weights.size() != generator.biases.size())
    fail("generated filter: {} weights and {} biases, expected as many of both and at least one",
         generator.weights.size(), generator.biases.size());
  expect_tensor("generated filter: x", "[B, N, X, H, W]", x,
                {kAnySize, kAnySize, kAnySize, kAnySize, kAnySize}, type);
  const int64_t batch = x.size(0), layers = x.size(1), height = x.size(3), width = x.size(4);
  const int64_t y = generator.weights[0].size(1) - x.size(2);
  expect_tensor("generated filter: shared", "[B, Y, H, W]", shared, {batch, y, height, width}, type);
  expect_tensor("generated filter: log_n", "[B, N, H, W]", log_n, {batch, layers, height, width}, type);
  expect_tensor("generated filter: values", "[B, N, C, H, W]", values,
                {batch, layers, kAnySize, height, width}, type);
}

/// What a fused filter works on: checked, finite, contiguous. values [B, N, C, H, W].
struct FusedFilter {
  FiniteSources sources;
  FullyConnectedWeights weights;
  Tensor x, shared, log_n, values;
  TileNetwork network;
  FilterShape shape;

  FusedFilter(const FullyConnectedWeights& generator, const Tensor& x_in, const Tensor& shared_in,
              const Tensor& log_n_in, const Tensor& values_in)
      : sources(
            (check(generator, x_in, shared_in, log_n_in, values_in), finite_sources(log_n_in, values_in))),
        weights(contiguous(generator)),
        x(x_in.contiguous()),
        shared(shared_in.contiguous()),
        log_n(sources.log_n.contiguous()),
        values(sources.values.contiguous()),
        network(
            tile_network(weights.weights, weights.biases, x.size(2), {false, float(weights.bound)}, false)),
        shape{x.size(1), expect_odd_kernel("generated filter", network.outputs()), values.size(2), x.size(3),
              x.size(4)} {}

  StretchGenerator generate() const { return {network, shape, x, shared}; }
  Tensor empty(int64_t planes) const {
    return at::empty({x.size(0), planes, shape.height, shape.width}, x.options());
  }
};

Tensor fused_splat(const FusedFilter& filter, bool joint) {
  const FilterShape& shape = filter.shape;
  const Tensor out = filter.empty((joint ? 1 : shape.layers) * shape.channels);
  const Pictures<float> o(out);
  const auto make_stage = [&] {
    return [generate = filter.generate()](int64_t b, const Stretch& at, SplatSourcesRow& row) mutable {
      generate(b, at, row.logits);
    };
  };
  run_splat(shape, joint, out.size(0), {Pictures<float>(filter.log_n), Pictures<float>(filter.values)},
            make_stage, [&](int64_t b) {
              return SplatResult{o[b], nullptr, nullptr, shape.plane()};
            });
  return unscaled(joint ? out : out.view(filter.values.sizes()), filter.sources);
}

Tensor fused_gather(const FusedFilter& filter) {
  const Tensor out = filter.empty(filter.shape.channels);
  run_gather(
      filter.shape, out.size(0), Pictures<float>(filter.log_n), Pictures<float>(filter.values),
      [&] { return filter.generate(); }, Pictures<float>(out), Pictures<float>(Tensor()));
  return unscaled(out, filter.sources);
}

}  // namespace

Tensor generated_splat(const FullyConnectedWeights& generator, const Tensor& x, const Tensor& shared,
                       const Tensor& log_n, const Tensor& values) {
  if (runs_fused(x)) return fused_splat({generator, x, shared, log_n, values}, /*joint=*/false);
  return in_strips(generator, x, shared, log_n, values, kernel_splat);
}

Tensor generated_splat_joint(const FullyConnectedWeights& generator, const Tensor& x, const Tensor& shared,
                             const Tensor& log_n, const Tensor& values) {
  if (runs_fused(x)) return fused_splat({generator, x, shared, log_n, values}, /*joint=*/true);
  return in_strips(generator, x, shared, log_n, values, kernel_splat_joint);
}

Tensor generated_gather(const FullyConnectedWeights& generator, const Tensor& x, const Tensor& shared,
                        const Tensor& log_n, const Tensor& values) {
  if (runs_fused(x) && x.dim() == 5 && x.size(1) == 1)
    return fused_gather({generator, x, shared, log_n.unsqueeze(1), values.unsqueeze(1)});
  return in_strips(generator, x, shared, log_n, values,
                   [](const Tensor& logits, const Tensor& given, const Tensor& v) {
                     return kernel_gather(logits.squeeze(1), given, v);
                   });
}

}  // namespace ld
