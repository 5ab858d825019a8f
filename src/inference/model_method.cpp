#include "inference/model_method.h"

#include <algorithm>

#include "graph/extent.h"
#include "models/graphs/network_cost.h"
#include "models/graphs/network_graph.h"

namespace ld {

LoadedModel load_model(const ModelArgument& argument, int threads) {
  return {argument, std::make_shared<const Denoiser>(argument.file), threads};
}

std::vector<LoadedModel> load_models(const std::vector<ModelArgument>& arguments, int threads,
                                     std::vector<std::string>& features) {
  std::vector<LoadedModel> models;
  for (const ModelArgument& argument : arguments) {
    models.push_back(load_model(argument, threads));
    for (const std::string& feature : models.back().denoiser->features())
      if (std::find(features.begin(), features.end(), feature) == features.end()) features.push_back(feature);
  }
  return models;
}

MethodCost cost_of(const LoadedModel& model, const Frame& frame) {
  const NetworkConfig& config = model.denoiser->network_config();
  const NetworkCost cost = multiply_adds(config, frame.spp, frame.height, frame.width);
  return {graph::parameter_count(network_graph(config)),
          cost.total() / static_cast<double>(frame.plane_size())};
}

Image denoise(const LoadedModel& model, const Frame& frame, SequenceState* sequence) {
  DenoiseOptions options;
  options.threads = model.threads;
  return model.denoiser->denoise(frame, options, sequence);
}

Method method_of(const LoadedModel& model, const MethodCost& cost) {
  return {model.argument.name,
          [model](const Frame& frame, SequenceState& state) { return denoise(model, frame, &state); }, cost};
}

}  // namespace ld
