// What happens to the items of a pixel by itself: fully connected networks, layers, and the picture at last.
#include "export/onnx_walk.h"
#include "models/network_numbers.h"

namespace ld {

Value onnx_bounded_softly(OnnxGraph& g, const Value& x, float c) {
  const Value bound = g.number(c), rest = g.div(bound, g.add(bound, g.op("Abs", {x})));
  return g.mul(g.op("Sign", {x}), g.sub(bound, g.mul(bound, rest)));
}

Value onnx_fully_connected(OnnxGraph& g, const graph::FullyConnected& op, int64_t outputs, const Value& x,
                           int64_t own, const Value& context) {
  const Value batch = g.size_of(x, 0), height = g.size_of(x, 3), width = g.size_of(x, 4);
  Value a = g.reshape(x, {-1, own, height, width});
  for (size_t i = 0; i < op.widths.size(); ++i) {
    const std::string name = op.weights + "." + std::to_string(i);
    const bool last = i + 1 == op.widths.size();
    Value weight = g.parameter(name + ".weight"), bias = g.parameter(name + ".bias");
    const int64_t made = last ? outputs : op.widths[i];
    if (made < op.widths[i]) {
      weight = g.slice(weight, 0, op.first_output, op.first_output + made);
      bias = g.slice(bias, 0, op.first_output, op.first_output + made);
    }
    if (i > 0 || context.name.empty()) {
      a = g.op("Conv", {a, weight, bias});
    } else {
      // What all samples or layers of a pixel share passes through the first layer once.
      const Value mine = g.op("Conv", {a, g.slice(weight, 1, 0, own)});
      const Value shared =
          g.op("Conv", {context, g.slice(weight, 1, own, std::numeric_limits<int64_t>::max()), bias});
      a = g.add(g.reshape(mine, {batch, -1, made, height, width}), g.unsqueeze(shared, 1));
      a = g.reshape(a, {-1, made, height, width});
    }
    if (!last || op.activate_last) a = onnx_activated(g, a);
    if (last && op.bound > 0) a = onnx_bounded_softly(g, a, float(op.bound));
  }
  return g.reshape(a, {batch, -1, outputs, height, width});
}

void to_onnx(const graph::FullyConnected& op, OnnxWalk& at) {
  const bool first_alone = at.out().items != at.in(0).items;
  const Value x = first_alone ? at.g.slice(at.read(0), 1, 0, 1) : at.read(0);
  at.make(onnx_fully_connected(at.g, op, at.out().channels, x, at.in(0).channels,
                               at.inputs() > 1 ? at.read_picture(1) : Value{}));
}

/// Without the opacity, which no picture is made of.
void to_onnx(const graph::Partition& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value valid = at.read(1), drawn = g.reduce_max(valid, {1});
  const Value empty = g.is_zero(drawn), lowest = g.number(-kInfinity);
  // Where no sample is valid all are counted, so that nothing divides 0 by 0, and the results are masked.
  const Value counted = g.where(empty, g.number(1), valid), count = g.reduce_sum(counted, {1});
  const Value z = g.clip(at.read(0), -kLargestLogit, kLargestLogit);
  const Value below = g.sub(z, g.reduce_max(z, {2}));
  const Value log_w =
      g.where(g.is_zero(counted), lowest, g.sub(below, g.log(g.reduce_sum(g.exp(below), {2}))));

  const auto nothing = [&] { return g.mul(drawn, g.number(0)); };
  const int64_t layers = at.in(0).channels;
  std::vector<Value> log_n, radiance, transmittance, embeddings;
  for (int64_t l = 0; l < layers; ++l) {
    // What each sample puts into layer l and, for alpha, those behind it, relative to n_l.
    const int64_t end = op.alpha ? layers : l + 1;
    const Value behind = g.slice(log_w, 2, l, end), largest = g.reduce_max(behind, {1, 2});
    const Value weights = g.exp(g.sub(behind, largest)), total = g.reduce_sum(weights, {1, 2});
    const Value q = g.div(weights, total);
    const Value share = g.slice(q, 2, 0, 1);  // w_s^l / (S n_l)
    radiance.push_back(g.reduce_sum(g.mul(share, at.read(2)), {1}));
    if (op.alpha)
      transmittance.push_back(l + 1 < end ? g.reduce_sum(g.slice(q, 2, 1, end - l), {1, 2}) : nothing());
    log_n.push_back(op.alpha && l == 0 ? nothing()  // n_0 = 1
                                       : g.add(g.log(total), g.sub(largest, g.log(count))));
    const Value weight = g.div(g.exp(g.slice(log_w, 2, l, l + 1)), count);
    embeddings.push_back(g.reduce_sum(g.mul(weight, at.read(3)), {1}));
  }
  const auto masked = [&](const std::vector<Value>& parts) { return g.mul(g.concat(parts, 1), drawn); };
  at.make(g.where(empty, lowest, g.concat(log_n, 1)), 0);
  at.make(masked(radiance), 1);
  at.make(masked(embeddings), 3);
  if (op.alpha) at.make(masked(transmittance), 4);
}

void to_onnx(const graph::Reject& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value logit =
      onnx_fully_connected(g, {op.weights, {1}}, 1, at.read(1), at.in(1).channels, at.read_picture(2));
  at.make(g.sub(at.read(0), g.mul(g.number(float(kMostRejected)), g.op("Sigmoid", {logit}))));
}

void to_onnx(const graph::LayerIdentity&, OnnxWalk& at) {
  const int64_t layers = at.out().channels;
  std::vector<float> one_each(size_t(layers * layers), 0.0F);
  for (int64_t l = 0; l < layers; ++l) one_each[size_t(l * layers + l)] = 1;
  at.make(at.g.expand(at.g.numbers(one_each, {1, layers, layers, 1, 1}),
                      {at.batch(), 1, 1, at.height(at.out()), at.width(at.out())}));
}

void to_onnx(const graph::Composite&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value filtered = at.read(0);
  const int64_t channels = at.out().channels;
  const auto plane = [&](int64_t layer, int64_t first, int64_t last) {
    return g.slice(g.slice(filtered, 1, layer, layer + 1), 2, first, last);
  };
  Value color = plane(0, 0, channels), visible;
  for (int64_t l = 1; l < at.layers(); ++l) {
    const Value through = plane(l - 1, channels, channels + 1);
    visible = l == 1 ? through : g.mul(visible, through);
    color = g.add(color, g.mul(visible, plane(l, 0, channels)));
  }
  at.make(color);
}

void to_onnx(const graph::Mix&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value k = g.mul(g.op("Sigmoid", {at.read(0)}), at.read(1));
  at.make(g.add(g.mul(k, at.read(2)), g.mul(g.sub(g.number(1), k), at.read(3))));
}

void to_onnx(const graph::ModulationFactors& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value modulators = at.read_picture(0), mean = g.slice(modulators, 1, 0, 3);
  const Value variance = g.op("AveragePool", {g.slice(modulators, 1, 3, 4)},
                              {{"kernel_shape", std::vector<int64_t>{3, 3}},
                               {"pads", std::vector<int64_t>{1, 1, 1, 1}},
                               {"count_include_pad", int64_t{0}}});
  const Value steady = g.exp(g.mul(variance, g.number(float(-kSteadyFalloff))));
  const Value logit = g.squeeze(
      onnx_fully_connected(g, {op.weights, {1}}, 1, g.unsqueeze(steady, 1), 1, at.read_picture(1)), 1);
  const Value known = g.to_float(g.op("Greater", {g.reduce_max(mean, {1}), g.number(0)}));
  at.make_picture(g.concat({mean, g.mul(g.op("Sigmoid", {logit}), known)}, 1));
}

void to_onnx(const graph::Modulate&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value filtered = at.read_picture(0), factors = at.read_picture(1);
  const Value plain = g.slice(filtered, 1, 3, 6), mean = g.slice(factors, 1, 0, 3);
  const Value within =
      g.to_float(g.op("LessOrEqual", {g.reduce_max(plain, {1}), g.number(float(kLargestModulated))}));
  const Value beta = g.mul(g.slice(factors, 1, 3, 4), within);
  at.make_picture(g.add(plain, g.mul(beta, g.sub(g.mul(mean, g.slice(filtered, 1, 0, 3)), plain))));
}

}  // namespace ld
