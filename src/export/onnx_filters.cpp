#include "export/onnx_filters.h"

#include "ops/kernels/constants.h"

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
/// weighted means.
Value merge_rows(OnnxGraph& g, const Value& largest, const Value& sums, int64_t channels, bool joint) {
  const std::vector<int64_t> over = joint ? std::vector<int64_t>{1, 3} : std::vector<int64_t>{3};
  const Value top = g.top(largest, over);
  const Value all = g.reduce_sum(g.mul(g.exp(g.sub(largest, top)), sums), over, false);
  const int64_t axis = joint ? 1 : 2;
  const Value weight = g.slice(all, axis, 0, 1), sum = g.slice(all, axis, 1, 1 + channels);
  return g.mul(g.div(sum, g.where(g.is_zero(weight), g.number(1), weight)),
               g.number(1 / float(kOverflowScale)));
}

Value bounded(OnnxGraph& g, const Value& logits) {
  return g.op("Clip", {logits, g.number(-kLargestLogit), g.number(kLargestLogit)});
}

/// [..., K*K, ...] along `axis` -> K times [..., K, ...].
std::vector<Value> kernel_rows(OnnxGraph& g, const Value& taps, int64_t kernel, int64_t axis) {
  if (kernel == 1) return {taps};
  return g.ops("Split", {taps}, size_t(kernel), {{"axis", axis}});
}

}  // namespace

Value onnx_splat(OnnxGraph& g, const Value& logits, const Value& log_n, const Value& values, int64_t kernel,
                 int64_t channels, bool joint) {
  const Value batch = g.size_of(logits, 0), layers = g.size_of(logits, 1), height = g.size_of(logits, 3),
              width = g.size_of(logits, 4), radius = g.whole({kernel / 2});
  const Value z = bounded(g, logits);
  const Value exponents = g.add(g.sub(z, g.reduce_max(z, {1, 2})), log_n);  // m_p over taps and layers

  // The values moved like the taps of a kernel row, [B * N, K, C, H, W + K - 1].
  const Value planes = g.mul(g.whole({channels}), height);
  const Value each = g.expand(
      g.reshape(g.mul(values, g.number(float(kOverflowScale))), {-1, 1, planes, width}), {1, kernel, 1, 1});
  const Value moved = g.reshape(shift_in_x(g, each, kernel, planes, width, 0),
                                {-1, kernel, channels, height, g.add(width, g.whole({kernel - 1}))});

  std::vector<Value> rows;
  for (const Value& row : kernel_rows(g, exponents, kernel, 2))
    rows.push_back(filter_row(g, shift_in_x(g, row, kernel, height, width, -kInfinity), moved));
  const Value arrived = g.slice(g.concat(rows, 2), 4, radius, g.add(width, radius));  // [B*N, 2+C, K, H, W]

  const auto of_picture = [&](int64_t first, int64_t count, float margin) {
    const Value some = g.slice(arrived, 1, first, first + count);
    return g.reshape(shift_in_y(g, some, kernel, height, width, margin),
                     {batch, layers, count, kernel, height, width});
  };
  return merge_rows(g, of_picture(0, 1, -kInfinity), of_picture(1, 1 + channels, 0), channels, joint);
}

Value onnx_gather(OnnxGraph& g, const Value& logits, const Value& log_n, const Value& values, int64_t kernel,
                  int64_t channels) {
  const Value height = g.size_of(logits, 3), width = g.size_of(logits, 4);
  const std::vector<Dim> margin = {0, 0, kernel / 2, kernel / 2};
  const Value sources = g.concat({g.pad(log_n, margin, margin, -kInfinity),
                                  g.pad(g.mul(values, g.number(float(kOverflowScale))), margin, margin, 0)},
                                 1);
  std::vector<Value> columns;  // what tap j of a kernel row reads, [B, 1, 1 + C, H + K - 1, W]
  for (int64_t j = 0; j < kernel; ++j)
    columns.push_back(g.unsqueeze(g.slice(sources, 3, j, g.add(width, g.whole({j}))), 1));
  const Value moved = g.concat(columns, 1);

  const Value z = g.squeeze(bounded(g, logits), 1);
  std::vector<Value> rows;
  for (const Value& row : kernel_rows(g, z, kernel, 1)) {
    const auto i = int64_t(rows.size());
    const Value read = g.slice(moved, 3, i, g.add(height, g.whole({i})));
    rows.push_back(
        filter_row(g, g.add(row, g.squeeze(g.slice(read, 2, 0, 1), 2)), g.slice(read, 2, 1, 1 + channels)));
  }
  const Value arrived = g.unsqueeze(g.concat(rows, 2), 1);  // [B, 1, 2 + C, K, H, W]
  return merge_rows(g, g.slice(arrived, 2, 0, 1), g.slice(arrived, 2, 1, 2 + channels), channels, true);
}

}  // namespace ld
