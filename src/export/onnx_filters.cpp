// Kernels, and the filters of ops/kernel_splat.h and ops/kernel_gather.h: softmax weights at the destination.
// A row of K taps is filtered at a time, to the largest exponent that arrives and the sums relative to it;
// the K results of a pixel are put together at the end. So the graph has some twenty nodes for a kernel row
// instead of ten for each of the K*K taps, and no tensor but the logits has K*K planes.
#include "export/onnx_walk.h"

namespace ld {
namespace {

/// Moves row i of a [..., rows, length] tensor to the right by i * step. Rows that are `step` too long, read
/// as rows of the right length, are just that; what a row loses at its end must be margin.
class RowShift {
 public:
  RowShift(OnnxGraph& g, int64_t rows, const Value& length, const Value& step)
      : g_(g),
        rows_(rows),
        length_(length),
        step_(step),
        stretched_(g.mul(g.whole({rows}), g.add(length, step))),
        cut_(g.mul(g.whole({rows}), length)) {}

  /// x of any shape that ends in rows * length elements; result [-1, rows, length].
  Value operator()(const Value& x, float margin) const {
    const Value rows = g_.reshape(x, {-1, rows_, length_});
    const Value flat = g_.reshape(g_.pad(rows, {0, 0, 0}, {0, 0, step_}, margin), {-1, stretched_});
    return g_.reshape(g_.slice(flat, 1, 0, cut_), {-1, rows_, length_});
  }

 private:
  OnnxGraph& g_;
  int64_t rows_;
  Value length_, step_, stretched_, cut_;
};

/// Taps j = 0 .. K-1 of one kernel row, [..., K, height, width], each moved to the right by j: [-1, K,
/// height, width + K - 1].
Value shift_in_x(OnnxGraph& g, const Value& x, int64_t kernel, const Value& height, const Value& width,
                 float margin) {
  const Value wide = g.add(width, g.whole({kernel - 1}));
  const Value padded =
      g.pad(g.reshape(x, {-1, kernel, height, width}), {0, 0, 0, 0}, {0, 0, 0, kernel - 1}, margin);
  const RowShift shift(g, kernel, g.mul(height, wide), g.whole({1}));
  return g.reshape(shift(padded, margin), {-1, kernel, height, wide});
}

/// Results of kernel rows i = 0 .. K-1, [..., K, height, width], each moved down by i and cropped to the
/// picture in whose middle row K/2 lies: [-1, K, height, width].
Value shift_in_y(OnnxGraph& g, const Value& x, int64_t kernel, const Value& height, const Value& width,
                 float margin) {
  const Value high = g.add(height, g.whole({kernel - 1})), radius = g.whole({kernel / 2});
  const Value padded =
      g.pad(g.reshape(x, {-1, kernel, height, width}), {0, 0, 0, 0}, {0, 0, kernel - 1, 0}, margin);
  const RowShift shift(g, kernel, g.mul(high, width), width);
  return g.slice(g.reshape(shift(padded, margin), {-1, kernel, high, width}), 2, radius,
                 g.add(height, radius));
}

/// exponents [M, K, h, w] of the taps of a kernel row, values [M, K, C, h, w] -> [M, 2 + C, 1, h, w]: the
/// largest exponent, and the sums of exp(exponent - largest) alone and times the values.
Value filter_row(OnnxGraph& g, const Value& exponents, const Value& values) {
  const Value largest = g.top(exponents, {1});
  const Value weights = g.exp(g.sub(exponents, largest));
  return g.unsqueeze(g.concat({largest, g.reduce_sum(weights, {1}),
                               g.reduce_sum(g.mul(g.unsqueeze(weights, 2), values), {1}, false)},
                              1),
                     2);
}

/// largest [B, N, 1, K, H, W] and sums [B, N, 1 + C, K, H, W] of the kernel rows that arrive at each pixel ->
/// weighted means [B, N, C, H, W], or [B, 1, C, H, W] of all N where `joint`.
Value merge_rows(OnnxGraph& g, const Value& largest, const Value& sums, int64_t channels, bool joint) {
  const std::vector<int64_t> over = joint ? std::vector<int64_t>{1, 3} : std::vector<int64_t>{3};
  const Value scales = g.exp(g.sub(largest, g.top(largest, over)));
  const Value all = g.squeeze(g.reduce_sum(g.mul(scales, sums), over), 3);
  const Value weight = g.slice(all, 2, 0, 1), sum = g.slice(all, 2, 1, 1 + channels);
  return g.mul(g.div(sum, g.where(g.is_zero(weight), g.number(1), weight)),
               g.number(1 / float(kOverflowScale)));
}

/// [..., K*K, H, W] -> K times [..., K, H, W].
std::vector<Value> kernel_rows(OnnxGraph& g, const Value& taps, int64_t kernel) {
  if (kernel == 1) return {taps};
  return g.ops("Split", {taps}, size_t(kernel), {{"axis", int64_t{2}}});
}

/// logits [B, N, K*K, H, W], log_n [B, N, 1, H, W], values [B, N, channels, H, W] -> as merge_rows().
Value splatted(OnnxGraph& g, const graph::Splat& op, const Value& logits, const Value& log_n,
               const Value& values, int64_t channels) {
  const int64_t kernel = op.kernel;
  const Value batch = g.size_of(logits, 0), items = g.size_of(logits, 1), height = g.size_of(logits, 3),
              width = g.size_of(logits, 4), radius = g.whole({kernel / 2});
  const Value z = g.clip(logits, -kLargestLogit, kLargestLogit);
  const Value exponents = g.add(g.sub(z, g.reduce_max(z, {1, 2})), log_n);  // m_p over taps and items

  // The values moved like the taps of a kernel row, [B * N, K, C, H, W + K - 1].
  const Value planes = g.mul(g.whole({channels}), height);
  const Value each = g.expand(
      g.reshape(g.mul(values, g.number(float(kOverflowScale))), {-1, 1, planes, width}), {1, kernel, 1, 1});
  const Value moved = g.reshape(shift_in_x(g, each, kernel, planes, width, 0),
                                {-1, kernel, channels, height, g.add(width, g.whole({kernel - 1}))});

  std::vector<Value> rows;
  for (const Value& row : kernel_rows(g, exponents, kernel))
    rows.push_back(filter_row(g, shift_in_x(g, row, kernel, height, width, -kInfinity), moved));
  const Value arrived = g.slice(g.concat(rows, 2), 4, radius, g.add(width, radius));  // [B*N, 2+C, K, H, W]

  const auto of_picture = [&](int64_t first, int64_t count, float margin) {
    const Value some = g.slice(arrived, 1, first, first + count);
    return g.reshape(shift_in_y(g, some, kernel, height, width, margin),
                     {batch, items, count, kernel, height, width});
  };
  return merge_rows(g, of_picture(0, 1, -kInfinity), of_picture(1, 1 + channels, 0), channels, op.joint);
}

/// logits [B or 1, 1, K*K, H or 1, W or 1] of what the node's inputs `log_n` and the next give to each pixel.
void gather(OnnxWalk& at, const Value& logits, int64_t kernel, size_t log_n) {
  OnnxGraph& g = at.g;
  const int64_t channels = at.out().channels;
  const Value height = at.height(at.out()), width = at.width(at.out());
  const std::vector<Dim> margin = {0, 0, 0, kernel / 2, kernel / 2};
  const Value values = g.mul(at.read(log_n + 1), g.number(float(kOverflowScale)));
  const Value sources =
      g.concat({g.pad(at.read(log_n), margin, margin, -kInfinity), g.pad(values, margin, margin, 0)}, 2);
  std::vector<Value> columns;  // what tap j of a kernel row reads, [B, 1, 1 + C, H + K - 1, W]
  for (int64_t j = 0; j < kernel; ++j) columns.push_back(g.slice(sources, 4, j, g.add(width, g.whole({j}))));
  const Value moved = g.concat(columns, 1);

  std::vector<Value> rows;
  for (const Value& row : kernel_rows(g, g.clip(logits, -kLargestLogit, kLargestLogit), kernel)) {
    const auto i = int64_t(rows.size());
    const Value read = g.slice(moved, 3, i, g.add(height, g.whole({i})));
    const Value exponents = g.add(g.squeeze(row, 1), g.squeeze(g.slice(read, 2, 0, 1), 2));
    rows.push_back(filter_row(g, exponents, g.slice(read, 2, 1, 1 + channels)));
  }
  const Value arrived = g.unsqueeze(g.concat(rows, 2), 1);  // [B, 1, 2 + C, K, H, W]
  at.make(merge_rows(g, g.slice(arrived, 2, 0, 1), g.slice(arrived, 2, 1, 2 + channels), channels, true));
}

/// The logits of all taps, from a node's embedding and context.
Value generated(OnnxWalk& at, const graph::FullyConnected& generator, int64_t kernel) {
  return onnx_fully_connected(at.g, generator, kernel * kernel, at.read(0), at.in(0).channels,
                              at.read_picture(1));
}

}  // namespace

void to_onnx(const graph::Splat& op, OnnxWalk& at) {
  int64_t channels = 0;
  std::vector<Value> values;
  for (size_t i = 3; i < at.inputs(); ++i) {
    channels += at.in(i).channels;
    values.push_back(at.read(i));
  }
  at.make(splatted(at.g, op, generated(at, op.generator, op.kernel), at.read(2), at.g.concat(values, 2),
                   channels));
}

void to_onnx(const graph::Gather& op, OnnxWalk& at) {
  gather(at, generated(at, op.generator, op.kernel), op.kernel, 2);
}

void to_onnx(const graph::GatherTaps& op, OnnxWalk& at) {
  const Value logits = at.read(0);
  gather(at, op.bound > 0 ? onnx_bounded_softly(at.g, logits, float(op.bound)) : logits, op.kernel, 1);
}

void to_onnx(const graph::Blur& op, OnnxWalk& at) {
  std::vector<float> logits;
  for (const double logit : op.logits()) logits.push_back(float(logit));
  gather(at, at.g.numbers(logits, {1, 1, op.kernel * op.kernel, 1, 1}), op.kernel, 0);
}

}  // namespace ld
