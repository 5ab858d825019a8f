// What a recurrent autoencoder sees of a frame and hands on to the next (models/recurrent.h).
#include "export/onnx_walk.h"
#include "models/network_numbers.h"

namespace ld {
namespace {

Value fifth_root(OnnxGraph& g, const Value& x) {
  return g.op("Pow", {x, g.number(float(kLightPower))});
}

}  // namespace

void to_onnx(const graph::TakeRoots& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value features = at.read(0), radiance = at.read(1), valid = at.read(2), zero = g.number(0);
  const auto feature = [&](int64_t first, int64_t channels) {
    return g.slice(features, 2, first, first + channels);
  };
  const Value light = onnx_masked_mean(g, radiance, valid), nothing = g.mul(light, zero);
  const auto mean = [&](int64_t first, int64_t channels) {
    return first < 0 ? g.slice(nothing, 2, 0, channels)
                     : onnx_masked_mean(g, feature(first, channels), valid);
  };
  const Value none = g.is_zero(g.reduce_max(valid, {1}));
  const Value surface =
      g.max(g.add(mean(op.albedo, 3), mean(op.specular, 3)), g.number(float(kLeastTexture)));
  const Value texture = fifth_root(g, g.where(none, g.number(1), surface));

  Value emitted = g.mul(radiance, zero);
  if (op.emission >= 0) emitted = onnx_tone_map_inverse(g, feature(op.emission, 3));
  if (op.depth >= 0)
    emitted = g.where(g.op("Greater", {g.number(1), feature(op.depth, 1)}), emitted, radiance);
  const Value emission = g.min(onnx_masked_mean(g, emitted, valid), g.number(float(kLargestEmission)));

  const Value least = g.mul(emission, g.number(float(1 + kLeastBesideEmission)));
  const Value root = g.div(fifth_root(g, g.max(g.sub(light, least), zero)), texture);
  at.make(g.concat({root, mean(op.normal, 2), mean(op.depth, 1), mean(op.roughness, 1)}, 2), 0);
  at.make(texture, 1);
  at.make(emission, 2);
}

void to_onnx(const graph::RaiseRoots&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value light = g.min(g.mul(g.max(at.read(0), g.number(0)), at.read(1)), g.number(float(kLargestRoot))),
              square = g.mul(light, light);
  at.make(g.add(g.mul(g.mul(square, square), light), at.read(2)));
}

void to_onnx(const graph::RecallPart& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  if (op.part >= 0)
    at.make_picture(g.clip(at.state(size_t(op.part)), -float(kLargestState), float(kLargestState)));
  else
    at.make_picture(
        g.expand(g.number(0), {at.batch(), at.out().channels, at.height(at.out()), at.width(at.out())}));
}

}  // namespace ld
