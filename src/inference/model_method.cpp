#include "inference/model_method.h"

#include <algorithm>

#include "models/graphs/network_cost.h"
#include "weights/named_weights.h"
#include "weights/weight_file.h"

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
  int64_t parameters = 0;
  const SafetensorsFile file(resolve_model(model.argument.file));
  for (const TensorView& tensor : file.tensors())
    if (!is_scale(file, tensor)) parameters += static_cast<int64_t>(tensor.bytes / dtype_bytes(tensor.type));
  const NetworkCost cost =
      multiply_adds(model.denoiser->network_config(), frame.spp, frame.height, frame.width);
  return {parameters, cost.total() / static_cast<double>(frame.plane_size())};
}

Image denoise(const LoadedModel& model, const Frame& frame) {
  DenoiseOptions options;
  options.threads = model.threads;
  return model.denoiser->denoise(frame, options);
}

Method method_of(const LoadedModel& model, const MethodCost& cost) {
  return {model.argument.name, [model](const Frame& frame, SequenceState&) { return denoise(model, frame); },
          cost};
}

}  // namespace ld
