#include "benchmark/planned_network.h"

#include "models/graphs/network_cost.h"
#include "models/graphs/network_graph.h"
#include "weights/model_file.h"

namespace ld {
namespace {

Frame random_frame(const NetworkConfig& config, const PictureExtent& picture) {
  Frame frame(int(picture.width), int(picture.height), int(picture.samples), frame_channels(config.features));
  frame.features = config.features;
  frame.info.depth_scale = 0.5f;
  for (const std::string& name : config.features) {
    const Feature& feature = find_feature(name);
    for (int s = 0; s < frame.spp; ++s)
      torch::from_blob(frame.plane(s, feature.offset), {feature.channels, picture.height, picture.width})
          .uniform_();
  }
  return frame;
}

}  // namespace

NetworkWeights bench_weights(const NetworkConfig& config) {
  return {config, network_graph(config), weights_of(*bench_network(config))};
}

PlannedNetwork::PlannedNetwork(NetworkWeights network, const PictureExtent& picture)
    : network_(std::move(network)),
      frame_(random_frame(network_.config, picture)),
      execution_(network_.graph, network_.weights, picture, {torch::get_num_threads()}) {}

double PlannedNetwork::multiply_adds() const {
  const PictureExtent& picture = execution_.picture();
  return ld::multiply_adds(network_.config, picture.samples, picture.height, picture.width).total();
}

double PlannedNetwork::bytes() const {
  double floats = 0;
  for (const graph::Parameter& parameter : parameters(network_.graph))
    floats += double(network_.weights.at(parameter.name).values.size());
  const auto channels = double(channel_count(network_.config.features));
  return sizeof(float) * (floats + double(frame_.plane_size()) * (frame_.spp * channels + 3));
}

}  // namespace ld
