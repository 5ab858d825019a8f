#include "models/graphs/layer_graph.h"

#include "core/error.h"
#include "frame/schema.h"
#include "models/graphs/shared_graph.h"

namespace ld {

using graph::Graph;
using graph::Items;
using graph::Value;
using graph::ValueId;

Graph layer_graph(const NetworkConfig& config) {
  if (config.name != "layer" || config.exposure_normalisation || config.means)
    fail("the runtime knows network 'layer' without exposure_normalisation and means, found '{}'",
         config.name);
  const bool alpha = config.compositing == "alpha", demodulated = config.demodulation == "albedo";
  const int64_t layers = config.layers, embedding_size = config.sample_reducer.back();
  Graph graph;
  graph.layers = layers;

  GraphInput input = add_input(graph, config);
  const ValueId embedding = add_fully_connected(
      graph, {"sample_reducer", int64_t(config.sample_reducer.size()), /*activate_last=*/true},
      embedding_size, input.features);
  const ValueId mean =
      graph.add(graph::MaskedMean{}, {embedding, input.valid}, {"mean", Items::picture, embedding_size});
  const ValueId context = add_unet(graph, config.unet, mean);

  ValueId modulators = 0;
  if (demodulated) {
    const ValueId forms = graph.add_value({"demodulated", Items::samples, 6});
    modulators = graph.add_value({"modulators", Items::picture, 4});
    graph.nodes.push_back({graph::Demodulate{first_channel(config.features, "albedo"),
                                             first_channel(config.features, "specular")},
                           {input.features, input.radiance, input.valid},
                           {forms, modulators}});
    input.radiance = forms;
  }
  const int64_t colours = graph[input.radiance].channels;

  const ValueId logits =
      add_fully_connected(graph, {"sample_partitioner", int64_t(config.sample_partitioner.size()) + 1},
                          layers, embedding, context);
  ValueId log_n = graph.add_value({"log_n", Items::layers, 1});
  const ValueId radiance = graph.add_value({"layer_radiance", Items::layers, colours});
  const ValueId opacity = graph.add_value({"opacity", Items::layers, 1});
  const ValueId layer_embedding = graph.add_value({"layer_embedding", Items::layers, embedding_size});
  std::vector<ValueId> parts = {log_n, radiance, opacity, layer_embedding};
  if (alpha) parts.push_back(graph.add_value({"transmittance", Items::layers, 1}));
  graph.nodes.push_back({graph::Partition{alpha}, {logits, input.valid, input.radiance, embedding}, parts});
  if (config.rejection)
    log_n = graph.add(graph::Reject{"rejection.weight"}, {log_n, layer_embedding, context},
                      {"weighed", Items::layers, 1});

  graph::Splat splat;
  splat.generator = {"kernel_generator", int64_t(config.kernel_generator.size()) + 1, false,
                     config.logit_bound};
  splat.kernel = config.kernel_size;
  splat.joint = !alpha;
  std::vector<ValueId> read = {layer_embedding, context, log_n, radiance};
  if (alpha) read.push_back(parts.back());
  ValueId picture = graph.add(
      splat, read,
      alpha ? Value{"filtered", Items::layers, colours + 1} : Value{"filtered", Items::picture, colours});
  if (alpha) picture = graph.add(graph::Composite{}, {picture}, {"composited", Items::picture, colours});
  if (demodulated)
    picture = graph.add(graph::Modulate{"modulation.weight"}, {picture, modulators, context},
                        {"picture", Items::picture, 3});
  graph.output = picture;
  return graph;
}

}  // namespace ld
