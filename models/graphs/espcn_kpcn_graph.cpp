#include "core/error.h"
#include "frame/schema.h"
#include "models/graphs/network_graph.h"
#include "models/graphs/shared_graph.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::Value;
using graph::ValueId;

namespace {

/// Channels [first, end) of a picture; nothing where there are none.
std::vector<ValueId> channels_of(Graph& graph, ValueId picture, int64_t first, int64_t end,
                                 const char* name) {
  if (first == end) return {};
  return {graph.add(graph::Channels{first}, {picture}, {name, Items::picture, end - first})};
}

ValueId add_convolution(Graph& graph, const std::string& weights, int64_t kernel, Activation activation,
                        const std::vector<ValueId>& inputs, int64_t outputs) {
  return graph.add(graph::EdgeConvolution{weights, kernel, activation}, inputs,
                   {weights, Items::picture, outputs, graph[inputs[0]].level});
}

/// models/super_resolution.h.
ValueId add_super_resolution(Graph& graph, const SuperResolutionConfig& config, std::vector<ValueId> x) {
  const Activation activation = config.activation == "tanh" ? Activation::tanh : Activation::relu;
  size_t i = 0;
  const auto name = [&] { return "super_resolution." + std::to_string(i); };
  for (; i < config.convolutions.size(); ++i)
    x = {add_convolution(graph, name(), i == 0 ? 5 : 3, activation, x, config.convolutions[i])};
  const ValueId deep = add_convolution(graph, name(), 3, Activation::none, x, 12);
  return graph.add(graph::DepthToSpace{}, {deep}, {"super_resolved", Items::picture, 3});
}

/// models/light_kpcn.h: the logits of its kernels.
ValueId add_kernels(Graph& graph, const NetworkConfig& config, const std::vector<ValueId>& x) {
  const int64_t width = config.super_resolution.denoiser;
  const ValueId a = add_convolution(graph, "denoiser.0", 3, Activation::relu, x, width),
                b = add_convolution(graph, "denoiser.1", 3, Activation::relu, {a}, width),
                sum = graph.add(graph::Add{}, {a, b}, {"skip", Items::picture, width});
  return add_convolution(graph, "denoiser.2", 3, Activation::none, {sum},
                         config.kernel_size * config.kernel_size);
}

}  // namespace

Graph espcn_kpcn_graph(const NetworkConfig& config, const graph::LightParts& parts) {
  if (parts.channels() > 0)
    fail_usage(
        "network 'espcn_kpcn' predicts colours, so that parts of the light and alpha cannot be filtered as "
        "the "
        "picture is; leave them out or use another network");
  Graph graph;
  GraphInput input = add_input(graph, config, parts);
  if (config.means) input = add_pixel_mean(graph, config, input);
  const bool is_given = first_channel(config.features, "half_radiance") >= 0;
  const int64_t channels = channel_count(config.features),
                first = first_channel(config.features, is_given ? "half_radiance" : "radiance");
  const ValueId features =
      graph.add(graph::MaskedMean{}, {input.features, input.valid}, {"means", Items::picture, channels});
  std::vector<ValueId> guides = channels_of(graph, features, 0, first, "guides");
  for (const ValueId more : channels_of(graph, features, first + 3, channels, "guides"))
    guides.push_back(more);
  const ValueId light = is_given ? channels_of(graph, features, first, first + 3, "half_light")[0]
                                 : add_mean_radiance(graph, input, "pixel_radiance");
  const ValueId drawn = graph.add(graph::AnyValid{}, {input.valid}, {"drawn", Items::picture, 1});
  std::optional<ValueId> reflectance;
  if (config.demodulation == "albedo")
    reflectance = graph.add(graph::Reflectance{first_channel(config.features, "albedo"),
                                               first_channel(config.features, "specular")},
                            {input.features, input.valid}, {"reflectance", Items::picture, 3});

  std::vector<ValueId> read = {light, drawn};
  const ValueId half_light = graph.add_value({"half_light", Items::picture, 3, 1}),
                half_known = graph.add_value({"half_known", Items::picture, 1, 1});
  std::vector<ValueId> made = {half_light, half_known};
  if (reflectance) {
    read.push_back(*reflectance);
    made.push_back(graph.add_value({"half_reflectance", Items::picture, 3, 1}));
  }
  graph.nodes.push_back({graph::HalveLight{is_given}, read, made});
  const auto upscaled = [&](ValueId half) {
    return graph.add(graph::Upsample{/*bilinear=*/false}, {half},
                     {"upscaled", Items::picture, graph[half].channels});
  };

  std::vector<ValueId> x;
  if (config.super_resolution.light()) x.push_back(half_light);
  for (size_t i = 0; i < guides.size() && config.super_resolution.guides(); ++i)
    x.push_back(graph.add(graph::SpaceToDepth{}, {guides[i]},
                          {"half_guides", Items::picture, 4 * graph[guides[i]].channels, 1}));
  const ValueId resolved = add_super_resolution(graph, config.super_resolution, x);

  x = {resolved};
  x.insert(x.end(), guides.begin(), guides.end());
  const ValueId logits = add_kernels(graph, config, x);
  const ValueId log_n = graph.add(graph::LogValid{}, {upscaled(half_known)}, {"log_n", Items::picture, 1});
  std::vector<ValueId> lit = {graph.add(graph::GatherTaps{config.kernel_size, config.logit_bound},
                                        {logits, log_n, resolved}, {"filtered", Items::picture, 3})};
  if (reflectance) lit.insert(lit.end(), {*reflectance, drawn, upscaled(made[2])});
  graph.output = graph.add(graph::Relight{}, lit, {"picture", Items::picture, 3});
  return graph;
}

}  // namespace ld
