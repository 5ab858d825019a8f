// What frames are before a network sees them, and what a pixel's samples have together.
#include "core/tone_map.h"
#include "export/onnx_walk.h"
#include "frame/schema.h"
#include "models/log_luminance.h"
#include "models/network_numbers.h"

namespace ld {
namespace {

/// The features with those of the radiance, from channel `first` on, made from `radiance`.
Value with_radiance_seen(OnnxWalk& at, const Value& features, const Value& radiance, const Value& valid,
                         int64_t first) {
  OnnxGraph& g = at.g;
  const int64_t channels = at.out().channels;
  const Value exposed = at.exposure.name.empty() ? radiance : g.mul(radiance, at.exposure);
  std::vector<Value> parts;
  if (first > 0) parts.push_back(g.slice(features, 2, 0, first));
  parts.push_back(g.mul(onnx_tone_mapped(g, g.min(exposed, g.number(kHalfMax))), valid));
  if (first + 3 < channels) parts.push_back(g.slice(features, 2, first + 3, channels));
  return g.concat(parts, 2);
}

/// models/exposure.h, [B, 1, 1, 1, 1]. In float32, where the C++ network computes it in float64.
Value exposure_of(OnnxGraph& g, const Value& radiance, const Value& valid) {
  const Value mean = onnx_masked_mean(g, radiance, valid), one = g.number(1);
  const auto part = [&](int64_t c, double weight) {
    return g.mul(g.slice(mean, 2, c, c + 1), g.number(float(weight)));
  };
  const Value light = g.add(g.add(part(0, luminance(1.0, 0.0, 0.0)), part(1, luminance(0.0, 1.0, 0.0))),
                            part(2, luminance(0.0, 0.0, 1.0)));
  const Value lit = g.op("Greater", {light, g.number(0)});
  const Value pixels = g.reduce_sum(g.to_float(lit), {2, 3, 4}),
              logs = g.reduce_sum(g.log(g.where(lit, light, one)), {2, 3, 4});
  const Value average = g.exp(g.div(logs, g.max(pixels, one)));
  return g.where(
      g.is_zero(pixels), one,
      g.min(g.div(g.number(float(kMiddleGrey)), average), g.number(std::numeric_limits<float>::max())));
}

}  // namespace

// log1p(x) = log(u) x / (u - 1) with the rounded u = 1 + x (Kahan) keeps the dark tones.
Value onnx_tone_mapped(OnnxGraph& g, const Value& x) {
  const Value one = g.number(1), u = g.add(one, x), rest = g.sub(u, one), small = g.is_zero(rest);
  const Value y = g.where(small, x, g.div(g.mul(g.log(u), x), g.where(small, one, rest)));
  const Value power = g.op("Pow", {y, g.number(1 / kSrgbExponent<float>)});
  return g.where(g.op("LessOrEqual", {y, g.number(kSrgbLinearTo<float>)}),
                 g.mul(y, g.number(kSrgbSlope<float>)),
                 g.sub(g.mul(power, g.number(kSrgbScale<float>)), g.number(kSrgbOffset<float>)));
}

// expm1(y) = (u - 1) y / log(u) with the rounded u = exp(y), likewise.
Value onnx_tone_map_inverse(OnnxGraph& g, const Value& mapped) {
  const Value within = g.clip(mapped, 0, 3), one = g.number(1);
  const Value shifted = g.add(within, g.number(kSrgbOffset<float>));
  const Value bent =
      g.op("Pow", {g.div(shifted, g.number(kSrgbScale<float>)), g.number(kSrgbExponent<float>)});
  const Value y = g.where(g.op("LessOrEqual", {within, g.number(0.04045F)}),
                          g.div(within, g.number(kSrgbSlope<float>)), bent);
  const Value u = g.exp(y), rest = g.sub(u, one), small = g.is_zero(rest);
  return g.min(g.where(small, y, g.div(g.mul(rest, y), g.where(small, one, g.log(u)))), g.number(kHalfMax));
}

Value onnx_masked_mean(OnnxGraph& g, const Value& values, const Value& valid) {
  const Value weights = g.div(valid, g.max(g.reduce_sum(valid, {1}), g.number(1)));
  return g.reduce_sum(g.mul(weights, values), {1});
}

Value onnx_demodulator(OnnxGraph& g, const Value& features, int64_t albedo, int64_t specular) {
  Value sum;
  for (const int64_t first : {albedo, specular}) {
    if (first < 0) continue;
    const Value reflectance = g.slice(features, 2, first, first + 3);
    sum = sum.name.empty() ? reflectance : g.add(sum, reflectance);
  }
  const Value none = g.op("LessOrEqual", {g.reduce_max(sum, {2}), g.number(float(kNoReflectance))});
  return g.where(none, g.number(1), g.clip(sum, float(kLeastReflectance), float(kMostReflectance)));
}

Value onnx_statistics(OnnxGraph& g, const Value& values, const Value& valid) {
  const Value mean = onnx_masked_mean(g, values, valid), rest = g.sub(values, mean);
  // The mean of many large values is rounded; what it misses is the mean of the rest.
  const Value missed = onnx_masked_mean(g, rest, valid), deviation = g.sub(rest, missed);
  return g.concat({g.add(mean, missed), onnx_masked_mean(g, g.mul(deviation, deviation), valid)}, 2);
}

/// The model's inputs, sanitised as by models/network_input.h.
void to_onnx(const graph::Encode& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value features = g.input("features", {"B", "S", std::to_string(at.out().channels), "H", "W"});
  const Value radiance = g.input("radiance", {"B", "S", "3", "H", "W"});
  at.valid = g.input("valid", {"B", "S", "1", "H", "W"});
  // 0 where all channels are finite, else NaN: 0 times infinity is NaN.
  const auto faults = [&](const Value& x) { return g.reduce_sum(g.mul(x, g.number(0)), {2}); };
  const Value bad = g.op("Not", {g.is_zero(g.add(faults(features), faults(radiance)))});
  const Value zero = g.number(0);
  const Value seen = g.clip(g.where(bad, zero, features), -kHalfMax, kHalfMax),
              light = g.max(g.where(bad, zero, radiance), zero),
              drawn = g.where(bad, zero, g.to_float(g.op("Not", {g.is_zero(at.valid)})));
  const int64_t first = first_channel(op.features, "radiance");
  const bool exposed = at.exposed() && first >= 0;
  if (exposed) at.exposure = exposure_of(g, light, drawn);
  at.make(exposed ? with_radiance_seen(at, seen, light, drawn, first) : seen, 0);
  at.make(light, 1);
  at.make(drawn, 2);
}

void to_onnx(const graph::MaskedMean&, OnnxWalk& at) {
  at.make(onnx_masked_mean(at.g, at.read(0), at.read(1)));
}

void to_onnx(const graph::AnyValid&, OnnxWalk& at) {
  at.make(at.g.reduce_max(at.read(0), {1}));
}

void to_onnx(const graph::LogValid&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  at.make(g.where(g.is_zero(at.read(0)), g.number(-kInfinity), g.number(0)));
}

void to_onnx(const graph::FirstValid&, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value values = at.read(0), valid = at.read(1);
  const Value first = g.op("ArgMax", {valid}, {{"axis", int64_t{1}}, {"keepdims", int64_t{1}}});
  const Value index = g.expand(first, {1, 1, at.out().channels, 1, 1});
  const Value theirs = g.op("GatherElements", {values, index}, {{"axis", int64_t{1}}});
  at.make(g.where(g.is_zero(valid), theirs, values));
}

void to_onnx(const graph::Statistics&, OnnxWalk& at) {
  at.make(onnx_statistics(at.g, at.read(0), at.read(1)));
}

void to_onnx(const graph::ToneMapped& op, OnnxWalk& at) {
  at.make(with_radiance_seen(at, at.read(0), at.read(1), at.read(2), op.first));
}

void to_onnx(const graph::Demodulate& op, OnnxWalk& at) {
  OnnxGraph& g = at.g;
  const Value radiance = at.read(1), a = onnx_demodulator(g, at.read(0), op.albedo, op.specular);
  const Value bounded_radiance = g.min(radiance, g.number(float(kLargestDemodulated)));
  at.make(g.concat({g.div(bounded_radiance, a), radiance}, 2), 0);

  const Value statistics = onnx_statistics(g, a, at.read(2));
  const Value mean = g.slice(statistics, 2, 0, 3), variance = g.slice(statistics, 2, 3, 6);
  const Value square = g.mul(mean, mean);
  const Value relative = g.reduce_sum(g.div(variance, g.where(g.is_zero(square), g.number(1), square)), {2});
  at.make(g.concat({mean, g.mul(relative, g.number(1 / 3.0F))}, 2), 1);
}

void to_onnx(const graph::Reflectance& op, OnnxWalk& at) {
  at.make(onnx_masked_mean(at.g, onnx_demodulator(at.g, at.read(0), op.albedo, op.specular), at.read(1)));
}

}  // namespace ld
