#include "core/error.h"
#include "frame/schema.h"
#include "models/graphs/network_graph.h"
#include "models/graphs/shared_graph.h"
#include "models/network_numbers.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::Value;
using graph::ValueId;

namespace {

/// models/recurrent.h, box by box.
class RecurrentGraph {
 public:
  explicit RecurrentGraph(Graph& graph) : graph_(graph) {}

  /// `like`: name of the weights, channels of the result.
  ValueId convolution(const std::string& name, int64_t channels, std::vector<ValueId> inputs,
                      double slope = kRecurrentSlope) {
    Value value = graph_[inputs[0]];
    value.name = "autoencoder." + name;
    value.channels = channels;
    const graph::Convolution op = {value.name, slope};
    return graph_.add(op, std::move(inputs), std::move(value));
  }

  ValueId convolutions(const std::string& name, const std::vector<int64_t>& widths,
                       std::vector<ValueId> inputs) {
    for (size_t i = 0; i < widths.size(); ++i)
      inputs = {convolution(name + "." + std::to_string(i), widths[i], std::move(inputs))};
    return inputs[0];
  }

  ValueId recurrent(int level, bool recurrence, ValueId x) {
    const std::string name = "recurrent" + std::to_string(level);
    const int64_t width = graph_[x].channels;
    const ValueId u = convolutions(name + ".input", {width}, {x});
    Value value = graph_[u];
    value.name = "recalled";
    const graph::RecallPart part = {recurrence ? int64_t(level) : -1};
    const ValueId before = graph_.add(part, {}, std::move(value));
    const ValueId h = convolutions(name + ".joint", {width, width}, {u, before});
    if (recurrence) graph_.state.push_back(h);
    return h;
  }

  ValueId pooled(ValueId x) {
    Value value = graph_[x];
    value.name = "pooled";
    ++value.level;
    return graph_.add(graph::MaxPool{}, {x}, std::move(value));
  }

  ValueId upsampled(ValueId x, bool bilinear) {
    Value value = graph_[x];
    value.name = "upsampled";
    --value.level;
    return graph_.add(graph::Upsample{bilinear}, {x}, std::move(value));
  }

 private:
  Graph& graph_;
};

}  // namespace

Graph recurrent_graph(const NetworkConfig& config, const graph::LightParts& parts) {
  if (parts.channels() > 0)
    fail_usage(
        "network '{}' makes the light itself and cannot filter parts of it or alpha; use a network that "
        "filters",
        config.name);
  Graph graph;
  const GraphInput input = add_input(graph, config);
  const auto first = [&](const char* feature) { return int64_t(first_channel(config.features, feature)); };
  const ValueId seen = graph.add_value({"seen", Items::picture, 7}),
                texture = graph.add_value({"texture", Items::picture, 3}),
                emission = graph.add_value({"emission", Items::picture, 3});
  graph.nodes.push_back({graph::TakeRoots{first("normal"), first("depth"), first("roughness"),
                                          first("albedo"), first("specular"), first("emission")},
                         {input.features, input.radiance, input.valid},
                         {seen, texture, emission}});

  RecurrentGraph at(graph);
  const auto levels = int(config.unet.encoder.size());
  graph.multiple = int64_t(1) << levels;
  ValueId x = graph.add(graph::Pad{}, {seen}, {"padded", Items::picture, 7, 0, /*padded=*/true});
  std::vector<ValueId> skips;
  for (int level = 0; level <= levels; ++level) {
    if (level > 0) x = at.pooled(x);
    x = at.convolutions("encoder" + std::to_string(level),
                        level < levels ? config.unet.encoder[size_t(level)] : config.unet.bottleneck, {x});
    x = at.recurrent(level, config.recurrence, x);
    skips.push_back(x);
  }
  skips.pop_back();
  for (int block = 0; block < levels; ++block) {
    x = at.upsampled(x, config.unet.upsampling == "bilinear");
    x = at.convolutions("decoder" + std::to_string(block), config.unet.decoder[size_t(block)],
                        {x, skips.back()});
    skips.pop_back();
  }
  const ValueId predicted = at.convolution("output", 3, {x}, /*slope=*/1);
  graph.output =
      graph.add(graph::RaiseRoots{}, {predicted, texture, emission}, {"picture", Items::picture, 3});
  return graph;
}

}  // namespace ld
