// The boxes of the U-net ([MH20] figure 3), and the levels of a pyramid of layers (section 6).
#include <cmath>

#include "export/onnx_walk.h"

namespace ld {

Value onnx_four_pixels(OnnxGraph& g, const Value& planes, float missing) {
  const auto odd = [&](int64_t axis) { return g.op("Mod", {g.size_of(planes, axis), g.whole({2})}); };
  const Value even = g.pad(planes, {0, 0, 0, 0, 0}, {0, 0, 0, odd(3), odd(4)}, missing);
  constexpr int64_t kEnd = std::numeric_limits<int64_t>::max();
  std::vector<Value> pixels;
  for (const int dy : {0, 1})
    for (const int dx : {0, 1})
      pixels.push_back(g.unsqueeze(g.slice(g.slice(even, 3, dy, kEnd, 2), 4, dx, kEnd, 2), 1));
  return g.concat(pixels, 1);
}

void to_onnx(const graph::Pad&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value below = g.sub(at.height(at.out()), at.height(at.in(0))),
              right = g.sub(at.width(at.out()), at.width(at.in(0)));
  at.make_picture(
      g.op("Pad", {at.read_picture(0), g.dims({0, 0, 0, 0, 0, 0, below, right})}, {{"mode", "edge"}}));
}

void to_onnx(const graph::Convolution& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  std::vector<Value> pictures;
  for (size_t i = 0; i < at.inputs(); ++i) pictures.push_back(at.read_picture(i));
  const Value y = g.op(
      "Conv", {g.concat(pictures, 1), g.parameter(op.weights + ".weight"), g.parameter(op.weights + ".bias")},
      {{"kernel_shape", std::vector<int64_t>{3, 3}}, {"pads", std::vector<int64_t>{1, 1, 1, 1}}});
  at.make_picture(op.slope == 1 ? y : onnx_activated(g, y, op.slope));
}

void to_onnx(const graph::MaxPool&, OnnxWalk& at) {
  at.make_picture(
      at.g.op("MaxPool", {at.read_picture(0)},
              {{"kernel_shape", std::vector<int64_t>{2, 2}}, {"strides", std::vector<int64_t>{2, 2}}}));
}

void to_onnx(const graph::Upsample& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value factor = g.whole({int64_t{1} << op.levels});
  const Value size = g.dims(
      {at.batch(), at.out().channels, g.mul(at.height(at.in(0)), factor), g.mul(at.width(at.in(0)), factor)});
  std::vector<Attribute> attributes = {{"mode", "linear"}, {"coordinate_transformation_mode", "half_pixel"}};
  if (!op.bilinear)
    attributes = {
        {"mode", "nearest"}, {"coordinate_transformation_mode", "asymmetric"}, {"nearest_mode", "floor"}};
  const Value fine = g.op("Resize", {at.read_picture(0), {}, {}, size}, attributes);
  at.make_picture(at.out().padded ? fine : at.cropped(fine, at.out()));
}

void to_onnx(const graph::Halve&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value log_n = onnx_four_pixels(g, at.read(0), -kInfinity), top = g.top(log_n, {1});
  const Value weights = g.exp(g.sub(log_n, top)), total = g.reduce_sum(weights, {1});
  at.make(g.squeeze(g.sub(g.add(g.log(total), top), g.number(std::log(4.0F))), 1), 0);

  const Value pixels = onnx_four_pixels(g, at.read(1), 0), sum = g.reduce_sum(pixels, {1});
  at.make(g.squeeze(sum, 1), 1);
  const auto mean = [&](size_t input, const Value& share) {
    at.make(g.reduce_sum(g.mul(share, onnx_four_pixels(g, at.read(input), 0)), {1}, false), input);
  };
  mean(2, g.div(pixels, g.max(sum, g.number(1))));
  const Value share = g.div(weights, g.where(g.is_zero(total), g.number(1), total));
  for (size_t i = 3; i < at.inputs(); ++i) mean(i, share);
}

void to_onnx(const graph::Received& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const int64_t radius = op.kernel / 2;
  at.make_picture(g.op("MaxPool", {g.to_float(g.op("Greater", {at.read_picture(0), g.number(0)}))},
                       {{"kernel_shape", std::vector<int64_t>{op.kernel, op.kernel}},
                        {"pads", std::vector<int64_t>{radius, radius, radius, radius}}}));
}

/// A pixel that received nothing is 0 in its level's picture. Upscaling blends it with its neighbours, and
/// dividing by what the upscaled pixel has of those that received something leaves their mean.
void to_onnx(const graph::BlendLevels&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  std::vector<Value> pictures, received;
  for (size_t i = 1; i < at.inputs(); i += 2) {
    pictures.push_back(at.read(i));
    received.push_back(at.read_picture(i + 1));
  }
  const Value coverage = g.concat(received, 1);  // [B, levels, H, W]
  const Value logits =
      g.where(g.op("Greater", {coverage, g.number(0)}), at.read_picture(0), g.number(-kInfinity));
  const Value weights = g.exp(g.sub(logits, g.top(logits, {1})));
  const Value sum = g.reduce_sum(g.mul(coverage, weights), {1});
  const Value share = g.div(weights, g.where(g.is_zero(sum), g.number(1), sum));
  at.make(g.reduce_sum(g.mul(g.unsqueeze(share, 2), g.concat(pictures, 1)), {1}));  // eq. 10
}

}  // namespace ld
