// The boxes of the U-net ([MH20] figure 3), row by row.
#include <algorithm>

#include "ops/kernels/convolution.h"
#include "runtime/row_step.h"

namespace ld {
namespace {

/// Sets what is behind the last pixel of each plane to 0.
void clear_tail(const RowWindow& window, int64_t y) {
  for (int64_t c = 0; c < window.planes; ++c)
    std::fill(window.row(y, c) + window.width, window.row(y, c) + padded(window.width), 0.0f);
}

class ConvolutionStep : public Step {
 public:
  ConvolutionStep(const graph::Convolution& op, const graph::Node& node, StepContext& context)
      : op_(op),
        context_(context),
        out_(context.output(node)),
        weights_(packed(op, context, out_.planes)),
        zeros_(size_t(padded(out_.width) + 2 * kPixelStep), 0.0f) {
    for (size_t i = 0; i < node.inputs.size(); ++i) inputs_.push_back(context.input(node, i));
  }

  void run(int64_t begin, int64_t end) override {
    const int64_t width = padded(out_.width);
    for_each_stretch(
        context_.threads, begin, end, width, kStretch, [&](int64_t y, int64_t x, int64_t count, int) {
          ConvolutionRow row;
          row.weights = &weights_;
          for (const RowWindow& in : inputs_)
            row.sources.push_back({{row_of(in, y - 1), row_of(in, y), row_of(in, y + 1)}, in.planes});
          row.out = out_.row(y);
          row.out_pitch = out_.pitch;
          row.begin = x;
          row.end = x + count;
          row.width = out_.width;
          row.activated = op_.activated;
          convolve(row);
        });
  }

 private:
  static constexpr int64_t kStretch = 480;  // pixels: whole blocks of every vector width

  static PackedConvolution packed(const graph::Convolution& op, const StepContext& context, int64_t outputs) {
    const NamedWeight& weight = context.weights.at(op.weights + ".weight");
    return {weight.values.data(), context.weights.at(op.weights + ".bias").values.data(), outputs,
            weight.shape[1]};
  }

  PlanarRow row_of(const RowWindow& in, int64_t y) const {
    if (y < 0 || y >= in.height) return {zeros_.data() + kPixelStep, 0};
    return in.planar(y);
  }

  graph::Convolution op_;
  StepContext& context_;
  std::vector<RowWindow> inputs_;
  RowWindow out_;
  PackedConvolution weights_;
  std::vector<float> zeros_;  // beyond the border
};

/// Of Upsample, as LibTorch's, corners not aligned: the centre of a fine pixel lies a quarter of a coarse one
/// from that one's centre.
struct UpsampleRow {
  graph::Upsample op;
  RowWindow in, out;

  void operator()(int64_t y, float* blended) const {
    for (int64_t c = 0; c < out.planes; ++c)
      if (op.bilinear)
        bilinear(y, c, blended);
      else
        nearest(y, c);
    clear_tail(out, y);
  }

  void nearest(int64_t y, int64_t c) const {
    const float* from = in.row(y / 2, c);
    float* to = out.row(y, c);
    for (int64_t x = 0; x < in.width; ++x) to[2 * x] = to[2 * x + 1] = from[x];
  }

  void bilinear(int64_t y, int64_t c, float* __restrict blended) const {
    const int64_t near = y / 2, far = std::clamp<int64_t>(y % 2 == 0 ? near - 1 : near + 1, 0, in.height - 1);
    const float* __restrict a = in.row(near, c);
    const float* __restrict b = in.row(far, c);
    float* __restrict to = out.row(y, c);
    const int64_t width = in.width;
    for (int64_t x = 0; x < width; ++x) blended[x] = 0.75f * a[x] + 0.25f * b[x];
    to[0] = blended[0];
    for (int64_t x = 0; x + 1 < width; ++x) {
      to[2 * x + 1] = 0.75f * blended[x] + 0.25f * blended[x + 1];
      to[2 * x + 2] = 0.25f * blended[x] + 0.75f * blended[x + 1];
    }
    to[2 * width - 1] = blended[width - 1];
  }
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::Pad&, const graph::Node& node, StepContext& context) {
  const RowWindow in = context.input(node, 0), out = context.output(node);
  return row_step(context, 0, [=](int64_t y, float*) {
    for (int64_t c = 0; c < in.planes; ++c) {
      float* to = out.row(y, c);
      std::copy_n(in.row(std::min(y, in.height - 1), c), in.width, to);
      std::fill(to + in.width, to + out.width, to[in.width - 1]);
    }
    clear_tail(out, y);
  });
}
std::unique_ptr<Step> make_step(const graph::Convolution& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<ConvolutionStep>(op, node, context);
}
std::unique_ptr<Step> make_step(const graph::MaxPool&, const graph::Node& node, StepContext& context) {
  const RowWindow in = context.input(node, 0), out = context.output(node);
  return row_step(context, 0, [=](int64_t y, float*) {
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
  return row_step(context, row.in.pitch, row);
}

}  // namespace ld
