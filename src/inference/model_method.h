// Models as methods of the evaluation, with what they cost.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "evaluation/method.h"
#include "inference/denoiser.h"

namespace ld {

struct LoadedModel {
  ModelArgument argument;
  std::shared_ptr<const Denoiser> denoiser;
  int threads = 0;  // that it runs on
};

LoadedModel load_model(const ModelArgument& argument, int threads);

/// `features` receives every feature that one of the models needs and that it does not hold yet. Throws Error
/// as Denoiser does.
std::vector<LoadedModel> load_models(const std::vector<ModelArgument>& arguments, int threads,
                                     std::vector<std::string>& features);

/// As Denoiser::denoise().
Image denoise(const LoadedModel& model, const Frame& frame, SequenceState* sequence = nullptr);

/// The model's parameters, and its multiply-adds a pixel (models/graphs/network_cost.h) for a frame of this
/// size and number of samples.
MethodCost cost_of(const LoadedModel& model, const Frame& frame);

/// The model as a method of that cost.
Method method_of(const LoadedModel& model, const MethodCost& cost);

}  // namespace ld
