// The boxes of the U-net ([MH20] figure 3), row by row.
#include <algorithm>
#include <type_traits>
#include <utility>

#include "ops/kernels/convolution.h"
#include "ops/kernels/quantised_convolution.h"
#include "ops/kernels/winograd.h"
#include "runtime/row_step.h"

namespace ld {
namespace {

/// Sets what is behind the last pixel of each plane to 0.
void clear_tail(const RowWindow& window, int64_t y) {
  for (int64_t c = 0; c < window.planes; ++c)
    std::fill(window.row(y, c) + window.width, window.row(y, c) + padded(window.width), 0.0f);
}

/// What both ways to a convolution share: where its inputs lie.
class ConvolutionInputs {
 public:
  ConvolutionInputs(const graph::Node& node, const StepContext& context)
      : zeros_(size_t(padded(context.output(node).width) + 5 * kPixelStep), 0.0f) {
    for (size_t i = 0; i < node.inputs.size(); ++i) windows_.push_back(context.input(node, i));
  }

  /// Rows [y, y + count) of each, zeros beyond the border.
  template <class Source>
  std::vector<Source> sources(int64_t y, size_t count) const {
    std::vector<Source> made;
    for (const RowWindow& in : windows_) {
      Source source;
      source.channels = in.planes;
      for (size_t i = 0; i < count; ++i) {
        const int64_t row = y + int64_t(i);
        source.rows[i] =
            row < 0 || row >= in.height ? PlanarRow{zeros_.data() + kPixelStep, 0} : in.planar(row);
      }
      made.push_back(source);
    }
    return made;
  }

 private:
  std::vector<RowWindow> windows_;
  std::vector<float> zeros_;
};

/// The weights of a convolution, packed.
template <class Packed>
Packed packed_weights(const graph::Convolution& op, const StepContext& context) {
  const NamedWeight& weight = context.weights.at(op.weights + ".weight");
  return {weight.values.data(), context.weights.at(op.weights + ".bias").values.data(), weight.shape[0],
          weight.shape[1]};
}

class DirectConvolutionStep : public Step {
 public:
  DirectConvolutionStep(const graph::Convolution& op, const graph::Node& node, StepContext& context)
      : op_(op),
        node_(node),
        context_(context),
        inputs_(node, context),
        out_(context.output(node)),
        weights_(packed_weights<PackedConvolution>(op, context)) {}

  void run(int64_t begin, int64_t end) override {
    for_each_stretch(
        context_.threads, begin, end, padded(out_.width), kStretch,
        [&](int64_t y, int64_t x, int64_t count, int) {
          if (!context_.demand.wants(node_, y, x, count)) return;
          convolve({&weights_, inputs_.sources<ConvolutionSource>(y - 1, 3), out_.row(y), out_.pitch, x,
                    x + count, out_.width, op_.slope == 1 ? Activation::none : Activation::leaky_relu,
                    float(op_.slope)});
        });
  }

 private:
  static constexpr int64_t kStretch = 480;  // pixels: whole blocks of every vector width

  graph::Convolution op_;
  const graph::Node& node_;
  StepContext& context_;
  ConvolutionInputs inputs_;
  RowWindow out_;
  PackedConvolution weights_;
};

/// By tiles of 2x2 results: in pairs of rows, an even one first, whatever rows are asked for.
template <class Weights, class Scratch>
class TiledConvolutionStep : public Step {
 public:
  TiledConvolutionStep(const graph::Convolution& op, const graph::Node& node, StepContext& context,
                       Weights weights)
      : op_(op),
        node_(node),
        context_(context),
        inputs_(node, context),
        out_(context.output(node)),
        weights_(std::move(weights)) {
    for (int t = 0; t < context.threads; ++t) scratch_.emplace_back(weights_);
  }

  /// The matrices of the weights take the place of these.
  int64_t scratch_bytes(int64_t) const override {
    const int64_t more = weights_.bytes() - 9 * weights_.outputs * weights_.inputs * Weights::kBytesOfOne;
    return context_.threads * Scratch::bytes(weights_) + more;
  }

  void run(int64_t begin, int64_t end) override {
    for_each_stretch(
        context_.threads, begin / 2, (end + 1) / 2, padded(out_.width), kWinogradPixels,
        [&](int64_t pair, int64_t x, int64_t count, int thread) {
          const int64_t y = 2 * pair;
          const auto row = [&](int64_t at) { return at >= begin && at < end ? out_.row(at) : nullptr; };
          const auto wanted = [&](int64_t at) {
            return row(at) != nullptr && context_.demand.wants(node_, at, x, count);
          };
          if (!wanted(y) && !wanted(y + 1)) return;
          convolve(TileRows<Weights>{&weights_,
                                     inputs_.sources<WinogradSource>(y - 1, WinogradSource().rows.size()),
                                     {row(y), row(y + 1)},
                                     out_.pitch,
                                     x,
                                     x + count,
                                     out_.width,
                                     float(op_.slope)},
                   scratch_[size_t(thread)]);
        });
  }

 private:
  graph::Convolution op_;
  const graph::Node& node_;
  StepContext& context_;
  ConvolutionInputs inputs_;
  RowWindow out_;
  Weights weights_;
  std::vector<Scratch> scratch_;
};

PackedQuantisedWeights packed_weights(const NamedWeight& weight, const NamedWeight& bias) {
  return {{weight.quantised->levels.data(), weight.quantised->scales.data(), bias.values.data(),
           weight.shape[0], weight.shape[1]},
          weight.quantised->input_range};
}

/// Of Upsample, as LibTorch's, corners not aligned: between the centres of two coarse pixels lie those of n
/// fine ones, the first half a fine pixel from the first.
struct UpsampleRow {
  graph::Upsample op;
  RowWindow in, out;

  void operator()(int64_t y, float* blended) const {
    for (int64_t c = 0; c < out.planes; ++c)
      if (!op.bilinear)
        nearest(y, c);
      else if (op.levels == 1)
        bilinear(y, c, std::integral_constant<int64_t, 2>(), blended);
      else
        bilinear(y, c, int64_t(1) << op.levels, blended);
    clear_tail(out, y);
  }

  void nearest(int64_t y, int64_t c) const {
    const float* from = in.row(y >> op.levels, c);
    float* to = out.row(y, c);
    for (int64_t x = 0; x < out.width; ++x) to[x] = from[x >> op.levels];
  }

  /// The coarse pixel whose centre comes before that of fine pixel `at`, and what the one behind counts for.
  struct Between {
    int64_t before;
    float behind;
    Between(int64_t at, int64_t n) : before((at + n / 2) / n - 1) {
      const int64_t from_centre = at - n / 2 - before * n;
      behind = (float(from_centre) + 0.5f) / float(n);
    }
  };

  template <class Factor>
  void bilinear(int64_t y, int64_t c, Factor factor, float* __restrict blended) const {
    const int64_t n = factor, width = in.width;
    const Between rows(y, n);
    const float* __restrict upper = in.row(std::max<int64_t>(rows.before, 0), c);
    const float* __restrict lower = in.row(std::min(rows.before + 1, in.height - 1), c);
    for (int64_t x = 0; x < width; ++x) blended[x] = (1 - rows.behind) * upper[x] + rows.behind * lower[x];
    float* __restrict to = out.row(y, c);
    const int64_t whole = std::clamp<int64_t>((out.width - n / 2) / n, 0, width - 1);  // gaps that are
    for (int64_t x = 0; x < whole; ++x)
      for (int64_t i = 0; i < n; ++i) {
        const float behind = (float(i) + 0.5f) / float(n);
        to[n / 2 + n * x + i] = (1 - behind) * blended[x] + behind * blended[x + 1];
      }
    const auto border = [&](int64_t begin, int64_t end) {
      for (int64_t x = begin; x < end; ++x) {
        const Between columns(x, n);
        to[x] = (1 - columns.behind) * blended[std::max<int64_t>(columns.before, 0)] +
                columns.behind * blended[std::min(columns.before + 1, width - 1)];
      }
    };
    border(0, std::min(n / 2, out.width));
    border(std::min(n / 2 + n * whole, out.width), out.width);
  }
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::Pad&, const graph::Node& node, StepContext& context) {
  const RowWindow in = context.input(node, 0), out = context.output(node);
  return row_step(context, node, 0, [=](int64_t y, float*) {
    for (int64_t c = 0; c < in.planes; ++c) {
      float* to = out.row(y, c);
      std::copy_n(in.row(std::min(y, in.height - 1), c), in.width, to);
      std::fill(to + in.width, to + out.width, to[in.width - 1]);
    }
    clear_tail(out, y);
  });
}
std::unique_ptr<Step> make_step(const graph::Convolution& op, const graph::Node& node, StepContext& context) {
  const NamedWeight& weight = context.weights.at(op.weights + ".weight");
  if (weight.quantised)
    return std::make_unique<TiledConvolutionStep<PackedQuantisedWeights, QuantisedScratch>>(
        op, node, context, packed_weights(weight, context.weights.at(op.weights + ".bias")));
  // Tiles are made 16 at a time: of narrow pictures most would be beyond the border.
  constexpr int64_t kNarrow = 24;
  if (context.output(node).width < kNarrow) return std::make_unique<DirectConvolutionStep>(op, node, context);
  return std::make_unique<TiledConvolutionStep<WinogradWeights, WinogradScratch>>(
      op, node, context, packed_weights<WinogradWeights>(op, context));
}
std::unique_ptr<Step> make_step(const graph::MaxPool&, const graph::Node& node, StepContext& context) {
  const RowWindow in = context.input(node, 0), out = context.output(node);
  return row_step(context, node, 0, [=](int64_t y, float*) {
    for (int64_t c = 0; c < out.planes; ++c) {
      const float* __restrict upper = in.row(2 * y, c);
      const float* __restrict lower = in.row(2 * y + 1, c);
      float* __restrict to = out.row(y, c);
      for (int64_t x = 0; x < out.width; ++x)
        to[x] = std::max(std::max(upper[2 * x], upper[2 * x + 1]), std::max(lower[2 * x], lower[2 * x + 1]));
    }
    clear_tail(out, y);
  });
}
std::unique_ptr<Step> make_step(const graph::Upsample& op, const graph::Node& node, StepContext& context) {
  const UpsampleRow row = {op, context.input(node, 0), context.output(node)};
  return row_step(context, node, row.in.pitch, row);
}

}  // namespace ld
