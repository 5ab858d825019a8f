#include "export/onnx_modules.h"

#include <cmath>
#include <limits>

#include "export/onnx_filters.h"
#include "frame/schema.h"
#include "models/network_numbers.h"
#include "ops/kernels/constants.h"

namespace ld {
namespace {

constexpr float kLargest = std::numeric_limits<float>::max();

/// Leaky ReLU as everywhere in [MH20].
Value activated(OnnxGraph& g, const Value& x) {
  return g.op("LeakyRelu", {x}, {{"alpha", float(kLeakySlope)}});
}

/// c x / (c + |x|) (ops/fully_connected.h).
Value bounded(OnnxGraph& g, const Value& x, float c) {
  const Value bound = g.number(c), rest = g.div(bound, g.add(bound, g.op("Abs", {x})));
  return g.mul(g.op("Sign", {x}), g.sub(bound, g.mul(bound, rest)));
}

/// The tone map of core/tone_map.h for x >= 0. log1p(x) = log(u) x / (u - 1) with the rounded u = 1 + x
/// (Kahan) keeps the dark tones.
Value tone_map(OnnxGraph& g, const Value& x) {
  const Value one = g.number(1), u = g.add(one, x), rest = g.sub(u, one), small = g.is_zero(rest);
  const Value y = g.where(small, x, g.div(g.mul(g.log(u), x), g.where(small, one, rest)));
  const Value power = g.op("Pow", {y, g.number(1 / 2.4F)});
  return g.where(g.op("LessOrEqual", {y, g.number(0.0031308F)}), g.mul(y, g.number(12.92F)),
                 g.sub(g.mul(power, g.number(1.055F)), g.number(0.055F)));
}

/// The features with those of the radiance, which begin at `channel`, made from `radiance`.
Value with_radiance_seen(OnnxGraph& g, const OnnxSamples& samples, const Value& radiance, int64_t channel,
                         int64_t channels) {
  std::vector<Value> parts;
  if (channel > 0) parts.push_back(g.slice(samples.features, 2, 0, channel));
  parts.push_back(g.mul(tone_map(g, radiance), samples.valid));
  if (channel + 3 < channels) parts.push_back(g.slice(samples.features, 2, channel + 3, channels));
  return g.concat(parts, 2);
}

Value convolution(OnnxGraph& g, const std::string& name, const Value& x) {
  return g.op("Conv", {x, g.parameter(name + ".weight"), g.parameter(name + ".bias")},
              {{"kernel_shape", std::vector<int64_t>{3, 3}}, {"pads", std::vector<int64_t>{1, 1, 1, 1}}});
}

/// Convolutions with leaky ReLUs; the weights are numbered as in torch::nn::Sequential, which counts both.
Value block(OnnxGraph& g, const std::string& name, size_t convolutions, Value x) {
  g.enter("unet/" + name);
  for (size_t i = 0; i < convolutions; ++i)
    x = activated(g, convolution(g, "unet." + name + "." + std::to_string(2 * i), x));
  return x;
}

Value max_pool(OnnxGraph& g, const Value& x) {
  return g.op("MaxPool", {x},
              {{"kernel_shape", std::vector<int64_t>{2, 2}}, {"strides", std::vector<int64_t>{2, 2}}});
}

/// The four pixels that become one, [B, N, C, H, W] -> [B, 4, N, C, ceil(H / 2), ceil(W / 2)]; `missing`
/// stands for those beyond an odd border.
Value four_pixels(OnnxGraph& g, const Value& planes, float missing) {
  const auto odd = [&](int64_t axis) { return g.op("Mod", {g.size_of(planes, axis), g.whole({2})}); };
  const Value even = g.pad(planes, {0, 0, 0, 0, 0}, {0, 0, 0, odd(3), odd(4)}, missing);
  constexpr int64_t kEnd = std::numeric_limits<int64_t>::max();
  std::vector<Value> pixels;
  for (const int dy : {0, 1})
    for (const int dx : {0, 1})
      pixels.push_back(g.unsqueeze(g.slice(g.slice(even, 3, dy, kEnd, 2), 4, dx, kEnd, 2), 1));
  return g.concat(pixels, 1);
}

OnnxPyramidLevel halve(OnnxGraph& g, const OnnxPyramidLevel& fine) {
  OnnxPyramidLevel coarse;
  const Value log_n = four_pixels(g, fine.layers.log_n, -kInfinity), top = g.top(log_n, {1});
  const Value weights = g.exp(g.sub(log_n, top)), total = g.reduce_sum(weights, {1});
  coarse.layers.log_n = g.squeeze(g.sub(g.add(g.log(total), top), g.number(std::log(4.0F))), 1);
  const Value share = g.div(weights, g.where(g.is_zero(total), g.number(1), total));
  const auto mean = [&](const Value& x) {
    return g.reduce_sum(g.mul(share, four_pixels(g, x, 0)), {1}, false);
  };
  coarse.layers.radiance = mean(fine.layers.radiance);
  if (!fine.layers.transmittance.name.empty()) coarse.layers.transmittance = mean(fine.layers.transmittance);

  const Value pixels = four_pixels(g, fine.pixels, 0), sum = g.reduce_sum(pixels, {1});
  coarse.pixels = g.squeeze(sum, 1);
  coarse.layers.embedding = g.reduce_sum(
      g.mul(g.div(pixels, g.max(sum, g.number(1))), four_pixels(g, fine.layers.embedding, 0)), {1}, false);
  return coarse;
}

}  // namespace

OnnxSamples onnx_sanitise(OnnxGraph& g, const Value& features, const Value& radiance, const Value& valid) {
  g.enter("sanitise");
  // 0 where all channels are finite, else NaN: 0 times infinity is NaN.
  const auto faults = [&](const Value& x) { return g.reduce_sum(g.mul(x, g.number(0)), {2}); };
  const Value bad = g.op("Not", {g.is_zero(g.add(faults(features), faults(radiance)))});
  const Value zero = g.number(0);
  OnnxSamples samples;
  samples.features = g.op("Clip", {g.where(bad, zero, features), g.number(-kHalfMax), g.number(kHalfMax)});
  samples.radiance = g.max(g.where(bad, zero, radiance), zero);
  samples.valid = g.where(bad, zero, g.to_float(g.op("Not", {g.is_zero(valid)})));
  samples.drawn = g.reduce_max(samples.valid, {1});
  return samples;
}

Value onnx_exposed(OnnxGraph& g, const OnnxSamples& samples, int64_t channel, int64_t channels) {
  g.enter("exposure");
  const Value mean = onnx_masked_mean(g, samples.radiance, samples.valid);  // [B, 3, H, W]
  const auto part = [&](int64_t c, float weight) {
    return g.mul(g.slice(mean, 1, c, c + 1), g.number(weight));
  };
  const Value luminance = g.add(g.add(part(0, 0.2126F), part(1, 0.7152F)), part(2, 0.0722F));
  const Value lit = g.op("Greater", {luminance, g.number(0)}), one = g.number(1);
  const Value pixels = g.reduce_sum(g.to_float(lit), {1, 2, 3}),
              logs = g.reduce_sum(g.log(g.where(lit, luminance, one)), {1, 2, 3});
  const Value average = g.exp(g.div(logs, g.max(pixels, one)));
  const Value exposure =
      g.where(g.is_zero(pixels), one,
              g.op("Min", {g.div(g.number(float(kMiddleGrey)), average), g.number(kLargest)}));
  const Value exposed = g.op("Min", {g.mul(samples.radiance, g.unsqueeze(exposure, 1)), g.number(kHalfMax)});
  return with_radiance_seen(g, samples, exposed, channel, channels);
}

OnnxSamples onnx_pixel_mean(OnnxGraph& g, const OnnxSamples& samples, int64_t channel, int64_t channels) {
  g.enter("pixel_mean");
  OnnxSamples mean = samples;
  mean.features = g.unsqueeze(onnx_masked_mean(g, samples.features, samples.valid), 1);
  mean.radiance = g.unsqueeze(onnx_masked_mean(g, samples.radiance, samples.valid), 1);
  mean.valid = samples.drawn;
  if (channel >= 0)
    mean.features =
        with_radiance_seen(g, mean, g.op("Min", {mean.radiance, g.number(kHalfMax)}), channel, channels);
  return mean;
}

Value onnx_demodulator(OnnxGraph& g, const NetworkConfig& config, const Value& features) {
  g.enter("demodulate");
  Value sum;
  for (const char* name : {"albedo", "specular"}) {
    const int64_t first = first_channel(config.features, name);
    if (first < 0) continue;
    const Value reflectance = g.slice(features, 2, first, first + 3);
    sum = sum.name.empty() ? reflectance : g.add(sum, reflectance);
  }
  const Value none = g.op("LessOrEqual", {g.reduce_max(sum, {2}), g.number(float(kNoReflectance))});
  return g.where(none, g.number(1),
                 g.op("Clip", {sum, g.number(float(kLeastReflectance)), g.number(float(kMostReflectance))}));
}

OnnxSamples onnx_demodulated(OnnxGraph& g, const OnnxSamples& samples, const Value& demodulator) {
  OnnxSamples both = samples;
  const Value bounded_radiance = g.op("Min", {samples.radiance, g.number(float(kLargestDemodulated))});
  both.radiance = g.concat({g.div(bounded_radiance, demodulator), samples.radiance}, 2);
  both.radiance_channels = 6;
  return both;
}

Value onnx_modulated(OnnxGraph& g, const OnnxSamples& samples, const Value& demodulator,
                     const Value& filtered, const Value& context) {
  const Value statistics = g.squeeze(onnx_sample_statistics(g, demodulator, samples.valid), 1);
  g.enter("modulate");
  const Value mean = g.slice(statistics, 1, 0, 3), variance = g.slice(statistics, 1, 3, 6);
  const Value square = g.mul(mean, mean);
  const Value relative =
      g.mul(g.reduce_sum(g.div(variance, g.where(g.is_zero(square), g.number(1), square)), {1}),
            g.number(1 / 3.0F));
  const Value average = g.op("AveragePool", {relative},
                             {{"kernel_shape", std::vector<int64_t>{3, 3}},
                              {"pads", std::vector<int64_t>{1, 1, 1, 1}},
                              {"count_include_pad", int64_t{0}}});
  const Value steady = g.exp(g.mul(average, g.number(float(-kSteadyFalloff))));
  const Value logit = g.squeeze(
      onnx_fully_connected(g, {"modulation.weight", 1, false, 1}, g.unsqueeze(steady, 1), context), 1);
  const Value plain = g.slice(filtered, 1, 3, 6);
  const Value known =
      g.mul(g.to_float(g.op("Greater", {g.reduce_max(mean, {1}), g.number(0)})),
            g.to_float(g.op("LessOrEqual", {g.reduce_max(plain, {1}), g.number(float(kLargestModulated))})));
  const Value beta = g.mul(g.op("Sigmoid", {logit}), known);
  return g.add(plain, g.mul(beta, g.sub(g.mul(mean, g.slice(filtered, 1, 0, 3)), plain)));
}

Value onnx_fully_connected(OnnxGraph& g, const OnnxLayers& network, const Value& x, const Value& context) {
  const Value batch = g.size_of(x, 0), height = g.size_of(x, 3), width = g.size_of(x, 4);
  Value a;
  int64_t outputs = 0;
  for (size_t i = 0; i < network.layers; ++i) {
    const std::string name = network.name + "." + std::to_string(i);
    const bool last = i + 1 == network.layers;
    Value weight = g.parameter(name + ".weight"), bias = g.parameter(name + ".bias");
    const int64_t inputs = g.parameter_shape(name + ".weight")[1];
    outputs = g.parameter_shape(name + ".weight")[0];
    if (last && network.count >= 0) {
      outputs = network.count;
      weight = g.slice(weight, 0, network.first, network.first + outputs);
      bias = g.slice(bias, 0, network.first, network.first + outputs);
    }
    if (i > 0) {
      a = g.op("Conv", {a, weight, bias});
    } else if (context.name.empty()) {
      a = g.op("Conv", {g.reshape(x, {-1, inputs, height, width}), weight, bias});
    } else {
      // What all samples or layers of a pixel share passes through the first layer once.
      const int64_t own = network.own_inputs;
      const Value mine = g.op("Conv", {g.reshape(x, {-1, own, height, width}), g.slice(weight, 1, 0, own)});
      const Value shared = g.op("Conv", {context, g.slice(weight, 1, own, inputs), bias});
      a = g.add(g.reshape(mine, {batch, -1, outputs, height, width}), g.unsqueeze(shared, 1));
      a = g.reshape(a, {-1, outputs, height, width});
    }
    if (!last || network.activate_last) a = activated(g, a);
    if (last && network.bound > 0) a = bounded(g, a, float(network.bound));
  }
  return g.reshape(a, {batch, -1, outputs, height, width});
}

Value onnx_masked_mean(OnnxGraph& g, const Value& values, const Value& valid) {
  const Value weights = g.div(valid, g.max(g.reduce_sum(valid, {1}), g.number(1)));
  return g.reduce_sum(g.mul(weights, values), {1}, false);
}

Value onnx_sample_statistics(OnnxGraph& g, const Value& values, const Value& valid) {
  g.enter("sample_statistics");
  const Value mean = onnx_masked_mean(g, values, valid);
  const Value rest = g.sub(values, g.unsqueeze(mean, 1));
  // The mean of many large values is rounded; what it misses is the mean of the rest.
  const Value missed = onnx_masked_mean(g, rest, valid);
  const Value deviation = g.sub(rest, g.unsqueeze(missed, 1));
  const Value variance = onnx_masked_mean(g, g.mul(deviation, deviation), valid);
  return g.unsqueeze(g.concat({g.add(mean, missed), variance}, 1), 1);
}

Value onnx_upsample(OnnxGraph& g, const Value& picture, int64_t factor, const UNetConfig& config) {
  const Value scale = g.whole({factor});
  const Value size = g.dims({g.size_of(picture, 0), g.size_of(picture, 1),
                             g.mul(g.size_of(picture, 2), scale), g.mul(g.size_of(picture, 3), scale)});
  if (config.upsampling == "bilinear")
    return g.op("Resize", {picture, {}, {}, size},
                {{"mode", "linear"}, {"coordinate_transformation_mode", "half_pixel"}});
  return g.op(
      "Resize", {picture, {}, {}, size},
      {{"mode", "nearest"}, {"coordinate_transformation_mode", "asymmetric"}, {"nearest_mode", "floor"}});
}

std::vector<Value> onnx_unet(OnnxGraph& g, const UNetConfig& config, const Value& input,
                             int64_t resolutions) {
  g.enter("unet");
  const Value height = g.size_of(input, 2), width = g.size_of(input, 3);
  const int64_t multiple = int64_t{1} << config.encoder.size();
  const auto missing = [&](const Value& size) {  // to the next multiple
    const Value m = g.whole({multiple});
    return g.op("Mod", {g.sub(m, g.op("Mod", {size, m})), m});
  };
  Value x =
      g.op("Pad", {input, g.dims({0, 0, 0, 0, 0, 0, missing(height), missing(width)})}, {{"mode", "edge"}});

  std::vector<Value> skips;
  for (size_t i = 0; i < config.encoder.size(); ++i) {
    skips.push_back(x);
    x = max_pool(g, block(g, "encoder" + std::to_string(i), config.encoder[i].size(), x));
  }
  x = block(g, "bottleneck", config.bottleneck.size(), x);

  const auto cropped = [&](const Value& picture, int64_t scale) {
    const auto part = [&](const Value& size) {
      return g.div(g.add(size, g.whole({scale - 1})), g.whole({scale}));
    };
    return g.slice(g.slice(picture, 2, 0, part(height)), 3, 0, part(width));
  };
  const auto blocks = int64_t(config.decoder.size());
  std::vector<Value> features(static_cast<size_t>(resolutions));
  for (int64_t resolution = blocks; resolution > 0; --resolution) {
    if (resolution < resolutions) features[size_t(resolution)] = cropped(x, int64_t{1} << resolution);
    const auto i = size_t(blocks - resolution);
    x = block(g, "decoder" + std::to_string(i), config.decoder[i].size(),
              g.concat({onnx_upsample(g, x, 2, config), skips[size_t(resolution - 1)]}, 1));
  }
  g.enter("unet/context");
  features[0] = cropped(convolution(g, "unet.context", x), 1);
  return features;
}

OnnxPartition onnx_partition(OnnxGraph& g, const NetworkConfig& config, const Value& logits,
                             const OnnxSamples& samples, const Value& embedding) {
  g.enter("partition");
  const bool alpha = config.compositing == "alpha";
  const Value empty = g.is_zero(samples.drawn), lowest = g.number(-kInfinity);
  // Where no sample is valid all are counted, so that nothing divides 0 by 0, and the results are masked.
  const Value counted = g.where(empty, g.number(1), samples.valid), count = g.reduce_sum(counted, {1});
  const Value z = g.op("Clip", {logits, g.number(-kLargestLogit), g.number(kLargestLogit)});
  const Value below = g.sub(z, g.reduce_max(z, {2}));
  const Value log_w =
      g.where(g.is_zero(counted), lowest, g.sub(below, g.log(g.reduce_sum(g.exp(below), {2}))));

  const Value nothing = g.mul(samples.drawn, g.number(0));
  std::vector<Value> log_n, radiance, transmittance, embeddings;
  for (int64_t l = 0; l < config.layers; ++l) {
    // What each sample puts into layer l and, for alpha, those behind it, relative to n_l.
    const int64_t end = alpha ? config.layers : l + 1;
    const Value behind = g.slice(log_w, 2, l, end), largest = g.reduce_max(behind, {1, 2});
    const Value weights = g.exp(g.sub(behind, largest)), total = g.reduce_sum(weights, {1, 2});
    const Value q = g.div(weights, total);
    const Value share = g.slice(q, 2, 0, 1);  // w_s^l / (S n_l)
    radiance.push_back(g.reduce_sum(g.mul(share, samples.radiance), {1}));
    transmittance.push_back(l + 1 < end ? g.reduce_sum(g.slice(q, 2, 1, end - l), {1, 2}) : nothing);
    log_n.push_back(alpha && l == 0 ? nothing  // n_0 = 1
                                    : g.add(g.log(total), g.sub(largest, g.log(count))));
    const Value weight = g.div(g.exp(g.slice(log_w, 2, l, l + 1)), count);
    embeddings.push_back(g.reduce_sum(g.mul(weight, embedding), {1}));
  }
  OnnxPartition layers;
  layers.log_n = g.where(empty, lowest, g.concat(log_n, 1));
  layers.radiance = g.mul(g.concat(radiance, 1), samples.drawn);
  if (alpha) layers.transmittance = g.mul(g.concat(transmittance, 1), samples.drawn);
  layers.embedding = g.mul(g.concat(embeddings, 1), samples.drawn);
  return layers;
}

std::vector<OnnxPyramidLevel> onnx_pyramid(OnnxGraph& g, const OnnxPartition& layers, int64_t levels) {
  g.enter("pyramid");
  const Value drawn = g.to_float(g.op("Greater", {layers.log_n, g.number(-kInfinity)}));
  std::vector<OnnxPyramidLevel> pyramid = {{layers, g.reduce_max(drawn, {1})}};
  while (int64_t(pyramid.size()) < levels) pyramid.push_back(halve(g, pyramid.back()));
  return pyramid;
}

}  // namespace ld
