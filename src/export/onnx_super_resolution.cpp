// Light at half resolution and sub-pixel convolutions (models/networks/espcn_kpcn_network.cpp).
#include "export/onnx_walk.h"
#include "frame/half_range.h"

namespace ld {

void to_onnx(const graph::EdgeConvolution& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  std::vector<Value> pictures;
  for (size_t i = 0; i < at.inputs(); ++i) pictures.push_back(at.read_picture(i));
  const int64_t r = op.kernel / 2;
  const Value wide =
      g.op("Pad", {g.concat(pictures, 1), g.dims({0, 0, r, r, 0, 0, r, r})}, {{"mode", "edge"}});
  const Value y = g.op("Conv", {wide, g.parameter(op.weights + ".weight"), g.parameter(op.weights + ".bias")},
                       {{"kernel_shape", std::vector<int64_t>{op.kernel, op.kernel}}});
  if (op.activation == Activation::leaky_relu)
    at.make_picture(onnx_activated(g, y));
  else if (op.activation == Activation::none)
    at.make_picture(y);
  else
    at.make_picture(g.op(op.activation == Activation::relu ? "Relu" : "Tanh", {y}));
}

void to_onnx(const graph::SpaceToDepth&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value x = at.read_picture(0);
  const auto odd = [&](int64_t axis) { return g.op("Mod", {g.size_of(x, axis), g.whole({2})}); };
  const Value even = g.op("Pad", {x, g.dims({0, 0, 0, 0, 0, 0, odd(2), odd(3)})}, {{"mode", "edge"}});
  constexpr int64_t kEnd = std::numeric_limits<int64_t>::max();
  std::vector<Value> pixels;
  for (const int dy : {0, 1})
    for (const int dx : {0, 1})
      pixels.push_back(g.unsqueeze(g.slice(g.slice(even, 2, dy, kEnd, 2), 3, dx, kEnd, 2), 2));
  at.make_picture(g.reshape(g.concat(pixels, 2),
                            {at.batch(), at.out().channels, at.height(at.out()), at.width(at.out())}));
}

void to_onnx(const graph::DepthToSpace&, OnnxWalk& at) {
  const Value whole =
      at.g.op("DepthToSpace", {at.read_picture(0)}, {{"blocksize", int64_t{2}}, {"mode", "CRD"}});
  at.make_picture(at.cropped(whole, at.out()));
}

void to_onnx(const graph::HalveLight& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value one = g.number(1), drawn = onnx_four_pixels(g, at.read(1), 0), count = g.reduce_sum(drawn, {1}),
              shares = g.div(drawn, g.max(count, one)), empty = g.squeeze(g.is_zero(count), 1);
  const auto halved = [&](size_t input) {
    return g.reduce_sum(g.mul(shares, onnx_four_pixels(g, at.read(input), 0)), {1}, false);
  };
  const bool demodulates = at.inputs() > 2;
  Value light = halved(0);
  if (!op.mapped) light = g.min(light, g.number(kHalfMax));
  if (demodulates) {
    const Value reflectance = g.where(empty, one, halved(2));
    light = g.div(op.mapped ? onnx_tone_map_inverse(g, light) : light, reflectance);
    at.make(reflectance, 2);
  }
  at.make(demodulates || !op.mapped ? onnx_tone_mapped(g, light) : light, 0);
  at.make(g.to_float(g.op("Not", {empty})), 1);
}

void to_onnx(const graph::Relight&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value linear = onnx_tone_map_inverse(g, at.read(0));
  if (at.inputs() == 1) {
    at.make(linear);
    return;
  }
  const Value drawn = g.op("Greater", {at.read(2), g.number(0)});
  at.make(g.mul(linear, g.where(drawn, at.read(1), at.read(3))));
}

void to_onnx(const graph::Channels& op, OnnxWalk& at) {
  at.make(at.g.slice(at.read(0), 2, op.first, op.first + at.out().channels));
}

void to_onnx(const graph::Add&, OnnxWalk& at) {
  at.make(at.g.add(at.read(0), at.read(1)));
}

}  // namespace ld
