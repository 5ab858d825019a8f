#include "models/graphs/shared_graph.h"

#include <algorithm>
#include <utility>

#include "frame/schema.h"
#include "models/check_network.h"
#include "ops/kernels/constants.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::Value;
using graph::ValueId;

GraphInput add_input(Graph& graph, const NetworkConfig& config, const graph::LightParts& parts) {
  graph.exposed = config.exposure_normalisation;
  graph.parts = parts;
  const int64_t channels = channel_count(config.features);
  const GraphInput input = {graph.add_value({"features", Items::samples, channels}),
                            graph.add_value({"radiance", Items::samples, 3 + parts.channels()}),
                            graph.add_value({"valid", Items::samples, 1})};
  graph.values[input.radiance].parts = parts.channels();
  graph.nodes.push_back({graph::Encode{config.features}, {}, {input.features, input.radiance, input.valid}});
  return input;
}

std::vector<int64_t> with_last(std::vector<int64_t> hidden, int64_t last) {
  hidden.push_back(last);
  return hidden;
}

ValueId add_fully_connected(Graph& graph, const graph::FullyConnected& op, ValueId x,
                            std::optional<ValueId> context) {
  std::vector<ValueId> inputs = {x};
  if (context) inputs.push_back(*context);
  return graph.add(op, std::move(inputs), {op.weights, graph[x].items, op.widths.back(), graph[x].level});
}

namespace {

/// Convolutions one after the other, the first on the channels of all inputs.
ValueId add_block(Graph& graph, const std::string& name, const std::vector<int64_t>& widths,
                  std::vector<ValueId> inputs) {
  for (size_t i = 0; i < widths.size(); ++i) {
    Value value = graph[inputs[0]];
    // A block's modules are convolutions and activations in turn.
    value.name = "unet." + name + "." + std::to_string(2 * i);
    value.channels = widths[i];
    const std::string weights = value.name;
    inputs = {graph.add(graph::Convolution{weights, kLeakySlope}, inputs, value)};
  }
  return inputs[0];
}

}  // namespace

ValueId add_reducer(Graph& graph, const NetworkConfig& config, ValueId features) {
  return add_fully_connected(graph, {"sample_reducer", config.sample_reducer, /*activate_last=*/true},
                             features);
}

ValueId add_mean_radiance(Graph& graph, const GraphInput& input, const char* name) {
  Value mean = graph[input.radiance];
  mean.name = name;
  mean.items = Items::picture;
  return graph.add(graph::MaskedMean{}, {input.radiance, input.valid}, std::move(mean));
}

GraphInput add_pixel_mean(Graph& graph, const NetworkConfig& config, const GraphInput& input) {
  const int64_t channels = graph[input.features].channels;
  GraphInput mean{};
  mean.radiance = add_mean_radiance(graph, input, "mean_radiance");
  mean.valid = graph.add(graph::AnyValid{}, {input.valid}, {"drawn", Items::picture, 1});
  mean.features = graph.add(graph::MaskedMean{}, {input.features, input.valid},
                            {"mean_features", Items::picture, channels});
  if (const int64_t first = first_channel(config.features, "radiance"); first >= 0)
    mean.features = graph.add(graph::ToneMapped{first}, {mean.features, mean.radiance, mean.valid},
                              {"seen", Items::picture, channels});
  return mean;
}

std::optional<ValueId> add_demodulation(Graph& graph, const NetworkConfig& config, GraphInput& input) {
  if (config.demodulation != "albedo") return std::nullopt;
  Value demodulated = graph[input.radiance];
  demodulated.name = "demodulated";
  demodulated.parts += demodulated.parts / 3 * 3;  // coloured ones have two forms, alpha one
  demodulated.channels = 6 + demodulated.parts;
  const ValueId forms = graph.add_value(std::move(demodulated)),
                modulators = graph.add_value({"modulators", Items::picture, 4});
  graph.nodes.push_back({graph::Demodulate{first_channel(config.features, "albedo"),
                                           first_channel(config.features, "specular")},
                         {input.features, input.radiance, input.valid},
                         {forms, modulators}});
  input.radiance = forms;
  return modulators;
}

ValueId add_modulation_factors(Graph& graph, ValueId modulators, ValueId context) {
  return graph.add(graph::ModulationFactors{"modulation.weight"}, {modulators, context},
                   {"factors", Items::picture, 4});
}

ValueId add_modulation(Graph& graph, ValueId filtered, std::optional<ValueId> modulators, ValueId context) {
  if (!modulators) return filtered;
  const int64_t of_parts = graph[filtered].channels - 6;
  return graph.add(graph::Modulate{}, {filtered, add_modulation_factors(graph, *modulators, context)},
                   {"picture", Items::picture, 3 + of_parts / 6 * 3 + of_parts % 3});
}

ValueId add_rejection(Graph& graph, const NetworkConfig& config, ValueId log_n, ValueId embedding,
                      ValueId context) {
  if (!config.rejection) return log_n;
  return graph.add(graph::Reject{"rejection.weight"}, {log_n, embedding, context},
                   {"weighed", graph[log_n].items, 1});
}

graph::Splat make_splat(const NetworkConfig& config, bool joint, int level) {
  int64_t outputs = config.kernel_size * config.kernel_size;
  const NetworkTraits& network = network_traits(config.name);
  if (level == 0 && network.has_levels && network.sources == Sources::layers)
    outputs += config.levels;  // lambda_i
  graph::Splat splat = {
      {"kernel_generator", with_last(config.kernel_generator, outputs), false, config.logit_bound},
      config.kernel_size,
      joint};
  // As many of full resolution, as far as that is worth it: what finer levels hold waits for them.
  splat.rows = std::max<int64_t>(splat.rows >> level, 8);
  return splat;
}

std::vector<ValueId> add_unet_features(Graph& graph, const UNetConfig& config, ValueId picture) {
  const int levels = int(config.encoder.size());
  graph.multiple = int64_t(1) << levels;
  Value value = {"padded", Items::picture, graph[picture].channels, 0, /*padded=*/true};
  ValueId x = graph.add(graph::Pad{}, {picture}, value);
  std::vector<ValueId> skips;
  for (int level = 0; level < levels; ++level) {
    skips.push_back(x);
    x = add_block(graph, "encoder" + std::to_string(level), config.encoder[size_t(level)], {x});
    value = graph[x];
    value.name = "pooled";
    ++value.level;
    x = graph.add(graph::MaxPool{}, {x}, value);
  }
  std::vector<ValueId> features = {x = add_block(graph, "bottleneck", config.bottleneck, {x})};
  for (int block = 0; block < levels; ++block) {
    value = graph[x];
    value.name = "upsampled";
    --value.level;
    x = graph.add(graph::Upsample{config.upsampling == "bilinear"}, {x}, value);
    x = add_block(graph, "decoder" + std::to_string(block), config.decoder[size_t(block)], {x, skips.back()});
    skips.pop_back();
    features.push_back(x);
  }
  value = graph[x];
  value.name = "context";
  value.channels = config.context;
  features.back() = graph.add(graph::Convolution{"unet.context"}, {x}, value);
  std::reverse(features.begin(), features.end());
  return features;
}

}  // namespace ld
