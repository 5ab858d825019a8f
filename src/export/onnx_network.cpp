#include "export/onnx_network.h"

#include "core/error.h"
#include "export/onnx_filters.h"
#include "export/onnx_modules.h"
#include "frame/schema.h"
#include "models/check_network.h"
#include "models/network_numbers.h"

namespace ld {
namespace {

/// models/sample_reducer.h.
Value reduce_samples(OnnxGraph& g, const NetworkConfig& config, const Value& features) {
  g.enter("sample_reducer");
  return onnx_fully_connected(g, {"sample_reducer", config.sample_reducer.size(), true}, features);
}

/// models/kernel_generator.h: outputs [first, first + count) of it.
Value generate(OnnxGraph& g, const NetworkConfig& config, const std::string& name, int64_t first,
               int64_t count, double bound, const Value& embedding, const Value& context) {
  g.enter(name);
  return onnx_fully_connected(
      g, {name, config.kernel_generator.size() + 1, false, config.sample_reducer.back(), first, count, bound},
      embedding, context);
}

/// The logits of its taps.
Value kernels(OnnxGraph& g, const NetworkConfig& config, const std::string& name, const Value& embedding,
              const Value& context) {
  return generate(g, config, name, 0, config.kernel_size * config.kernel_size, config.logit_bound, embedding,
                  context);
}

/// models/rejection.h.
Value weighed(OnnxGraph& g, const NetworkConfig& config, const Value& log_n, const Value& embedding,
              const Value& context) {
  if (!config.rejection) return log_n;
  g.enter("rejection");
  const Value logit = onnx_fully_connected(g, {"rejection.weight", 1, false, config.sample_reducer.back()},
                                           embedding, context);
  const Value rejected = g.op("Sigmoid", {logit});
  return g.sub(log_n, g.mul(g.number(float(kMostRejected)), rejected));
}

/// What is filtered, before its modulation, and the context at full resolution.
struct Filtered {
  Value picture;  // [B, radiance_channels, H, W]
  Value context;
};

/// models/compositor.h: [B, channels, H, W].
Value filter_and_composite(OnnxGraph& g, const NetworkConfig& config, const std::string& generator,
                           const OnnxPartition& layers, int64_t channels, const Value& context) {
  const int64_t kernel = config.kernel_size;
  const Value logits = kernels(g, config, generator, layers.embedding, context);
  g.enter(generator + "/splat");
  if (config.compositing == "weighted")
    return onnx_splat(g, logits, layers.log_n, layers.radiance, kernel, channels, true);
  const Value filtered =
      onnx_splat(g, logits, layers.log_n, g.concat({layers.radiance, layers.transmittance}, 2), kernel,
                 channels + 1, false);
  g.enter(generator + "/composite");
  const auto plane = [&](int64_t layer, int64_t first, int64_t last) {
    return g.squeeze(g.slice(g.slice(filtered, 1, layer, layer + 1), 2, first, last), 1);
  };
  Value color = plane(0, 0, channels), visible = plane(0, channels, channels + 1);
  for (int64_t l = 1; l < config.layers; ++l) {
    color = g.add(color, g.mul(visible, plane(l, 0, channels)));
    visible = g.mul(visible, plane(l, channels, channels + 1));
  }
  return color;
}

/// models/networks/layered_network.h.
struct Layers {
  std::vector<Value> context;
  OnnxPartition partition;
};

Layers make_layers(OnnxGraph& g, const NetworkConfig& config, const OnnxSamples& samples,
                   int64_t resolutions) {
  const Value embedding = reduce_samples(g, config, samples.features);
  Layers layers;
  layers.context = onnx_unet(g, config.unet, onnx_masked_mean(g, embedding, samples.valid), resolutions);
  g.enter("sample_partitioner");
  const Value logits = onnx_fully_connected(
      g, {"sample_partitioner", config.sample_partitioner.size() + 1, false, config.sample_reducer.back()},
      embedding, layers.context[0]);
  layers.partition = onnx_partition(g, config, logits, samples, embedding);
  layers.partition.log_n =
      weighed(g, config, layers.partition.log_n, layers.partition.embedding, layers.context[0]);
  return layers;
}

/// models/networks/layer_network.h.
Filtered layer(OnnxGraph& g, const NetworkConfig& config, const OnnxSamples& samples) {
  const Layers layers = make_layers(g, config, samples, 1);
  return {filter_and_composite(g, config, "kernel_generator", layers.partition, samples.radiance_channels,
                               layers.context[0]),
          layers.context[0]};
}

/// models/networks/optimized_network.h.
Filtered optimized(OnnxGraph& g, const NetworkConfig& config, const OnnxSamples& samples) {
  const Layers layers = make_layers(g, config, samples, config.levels);
  const std::vector<OnnxPyramidLevel> pyramid = onnx_pyramid(g, layers.partition, config.levels);
  const int64_t kernel = config.kernel_size, radius = kernel / 2;
  const Value height = g.size_of(samples.valid, 3), width = g.size_of(samples.valid, 4), one = g.number(1);
  const auto upscaled = [&](const Value& picture, int64_t level) {
    if (level == 0) return picture;
    const Value fine = onnx_upsample(g, picture, int64_t{1} << level, config.unet);
    return g.slice(g.slice(fine, 2, 0, height), 3, 0, width);
  };

  std::vector<Value> pictures, log_coverage;
  for (int64_t i = 0; i < config.levels; ++i) {
    const OnnxPyramidLevel& level = pyramid[size_t(i)];
    const Value picture =
        filter_and_composite(g, config, "kernel_generator" + std::to_string(i), level.layers,
                             samples.radiance_channels, layers.context[size_t(i)]);  // G_i
    g.enter("levels");
    // Where the kernels of a level reach from a pixel with samples.
    const Value received =
        g.op("MaxPool", {g.to_float(g.op("Greater", {g.squeeze(level.pixels, 1), g.number(0)}))},
             {{"kernel_shape", std::vector<int64_t>{kernel, kernel}},
              {"pads", std::vector<int64_t>{radius, radius, radius, radius}}});
    const Value coverage = upscaled(received, i);
    const Value own = g.div(upscaled(picture, i), g.where(g.is_zero(coverage), one, coverage));
    pictures.push_back(g.unsqueeze(own, 1));
    log_coverage.push_back(g.log(coverage));
  }
  const Value known = g.concat(log_coverage, 1);  // -inf for a level without anything to say
  const Value nothing = g.op("Equal", {g.reduce_max(known, {1}), g.number(-kInfinity)});
  const Value first_layer = g.slice(pyramid[0].layers.embedding, 1, 0, 1);
  const Value lambda = g.squeeze(generate(g, config, "kernel_generator0", kernel * kernel, config.levels, 0,
                                          first_layer, layers.context[0]),
                                 1);
  g.enter("levels");
  const Value logits = g.add(lambda, g.where(nothing, g.number(0), known));
  const Value weights = g.exp(g.sub(logits, g.reduce_max(logits, {1})));
  const Value share = g.div(weights, g.reduce_sum(weights, {1}));                         // [B, levels, H, W]
  return {g.reduce_sum(g.mul(g.unsqueeze(share, 2), g.concat(pictures, 1)), {1}, false),  // eq. 10
          layers.context[0]};
}

/// models/networks/pixel_network.h.
Filtered pixel(OnnxGraph& g, const NetworkConfig& config, const OnnxSamples& samples, bool gather) {
  const Value embedding =
      reduce_samples(g, config, onnx_sample_statistics(g, samples.features, samples.valid));
  const Value context = onnx_unet(g, config.unet, g.squeeze(embedding, 1), 1)[0];
  const int64_t kernel = config.kernel_size, channels = samples.radiance_channels;
  const Value logits = kernels(g, config, "kernel_generator", embedding, context);
  g.enter("filter");
  const Value radiance = onnx_masked_mean(g, samples.radiance, samples.valid);
  const Value equal = g.where(g.is_zero(samples.drawn), g.number(-kInfinity), g.number(0));
  if (gather) return {onnx_gather(g, logits, g.squeeze(equal, 1), radiance, kernel, channels), context};
  const Value log_n = weighed(g, config, equal, embedding, context);
  return {g.squeeze(onnx_splat(g, logits, log_n, g.unsqueeze(radiance, 1), kernel, channels, false), 1),
          context};
}

/// models/networks/sample_splat_network.h.
Filtered sample_splat(OnnxGraph& g, const NetworkConfig& config, const OnnxSamples& samples) {
  g.enter("valid_features");
  // A sample that is not valid takes the features of the pixel's first valid one.
  const Value missing = g.is_zero(samples.valid);
  const Value first = g.op("ArgMax", {samples.valid}, {{"axis", int64_t{1}}, {"keepdims", int64_t{1}}});
  const Value index = g.expand(first, {1, 1, channel_count(config.features), 1, 1});
  const Value theirs = g.op("GatherElements", {samples.features, index}, {{"axis", int64_t{1}}});
  const Value features = g.where(missing, theirs, samples.features);

  const Value embedding = reduce_samples(g, config, features);
  const Value context = onnx_unet(g, config.unet, onnx_masked_mean(g, embedding, samples.valid), 1)[0];
  const Value logits = kernels(g, config, "kernel_generator", embedding, context);
  g.enter("splat");
  const Value equal = g.where(missing, g.number(-kInfinity), g.number(0));
  const Value log_n = weighed(g, config, equal, embedding, context);
  return {onnx_splat(g, logits, log_n, samples.radiance, config.kernel_size, samples.radiance_channels, true),
          context};
}

Filtered filtered(OnnxGraph& g, const NetworkConfig& config, const OnnxSamples& samples) {
  const NetworkTraits& network = network_traits(config.name);
  if (network.filter == Filter::own)
    fail("network '{}' has no ONNX form; export it as safetensors", config.name);
  switch (network.sources) {
    case Sources::layers:
      return network.has_levels ? optimized(g, config, samples) : layer(g, config, samples);
    case Sources::samples:
      return sample_splat(g, config, samples);
    case Sources::pixels:
      return pixel(g, config, samples, network.filter == Filter::gather);
  }
  fail("ONNX: network '{}' has sources of an unknown kind", config.name);
}

}  // namespace

onnx::ModelProto onnx_model(const NetworkConfig& config, const std::vector<TensorView>& weights) {
  OnnxGraph g(weights);
  const int64_t channels = channel_count(config.features);
  const Value features = g.input("features", {"B", "S", std::to_string(channels), "H", "W"});
  const Value radiance = g.input("radiance", {"B", "S", "3", "H", "W"});
  const Value valid = g.input("valid", {"B", "S", "1", "H", "W"});
  OnnxSamples samples = onnx_sanitise(g, features, radiance, valid);
  const int64_t first_radiance = first_channel(config.features, "radiance");
  if (config.means) samples = onnx_pixel_mean(g, samples, first_radiance, channels);
  if (config.exposure_normalisation && first_radiance >= 0)
    samples.features = onnx_exposed(g, samples, first_radiance, channels);
  Value image;
  if (config.demodulation == "none") {
    image = filtered(g, config, samples).picture;
  } else {
    const Value a = onnx_demodulator(g, config, samples.features);
    const Filtered modulated = filtered(g, config, onnx_demodulated(g, samples, a));
    image = onnx_modulated(g, samples, a, modulated.picture, modulated.context);
  }
  g.output(image, "image", {"B", "3", "H", "W"});
  return g.model();
}

}  // namespace ld
