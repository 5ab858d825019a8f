#include "models/initialise.h"

#include <cmath>
#include <set>

#include "core/checksum.h"
#include "core/random.h"
#include "models/demodulation.h"
#include "models/history.h"
#include "models/kernel_generator.h"
#include "models/light_kpcn.h"
#include "models/network_numbers.h"
#include "models/rejection.h"
#include "models/super_resolution.h"
#include "models/unet.h"
#include "ops/kernels/constants.h"

namespace ld {
namespace {

using torch::Tensor;

/// The weights that no activation follows.
std::set<std::string> output_weights(Network& network) {
  const NetworkConfig& config = network.config();
  std::set<std::string> names;
  for (const auto& entry : network.named_modules("", /*include_self=*/false)) {
    if (const auto* layers = dynamic_cast<const FullyConnected*>(entry.value().get());
        layers != nullptr && layers->last() == LastLayer::linear)
      names.insert(entry.key() + "." + std::to_string(layers->weights().weights.size() - 1) + ".weight");
    if (dynamic_cast<const UNet*>(entry.value().get()) != nullptr)
      names.insert(entry.key() + ".context.weight");
    if (dynamic_cast<const SuperResolution*>(entry.value().get()) != nullptr)
      names.insert(entry.key() + "." + std::to_string(config.super_resolution.convolutions.size()) +
                   ".weight");
    if (dynamic_cast<const LightKpcn*>(entry.value().get()) != nullptr)
      names.insert(entry.key() + ".2.weight");
  }
  return names;
}

/// Largest weight of the uniform distribution.
double bound_of(const Tensor& weight, bool he, double slope) {
  const double taps = double(weight[0][0].numel()), inputs = taps * double(weight.size(1)),
               outputs = taps * double(weight.size(0));
  return std::sqrt(he ? 6.0 / ((1 + slope * slope) * inputs) : 6.0 / (inputs + outputs));
}

/// Keyed by the parameter's name: no weight depends on what else the network holds.
void fill_uniform(Tensor& weight, const std::string& name, float bound, uint64_t seed) {
  RandomStream stream(seed, RandomPurpose::initial_weights, uint32_t(checksum(name.data(), name.size())));
  const Tensor values = torch::empty(weight.sizes(), torch::kFloat32);
  float* value = values.data_ptr<float>();
  for (int64_t i = 0; i < values.numel(); ++i) value[i] = stream.uniform(-bound, bound);
  weight.copy_(values);
}

}  // namespace

std::vector<double> gaussian_logits(int64_t kernel, double sigma, double bound) {
  // Of a bounded logit: from half the bound at the centre to where its slope is 1 % of that at 0.
  const double top = bound > 0 ? 0.5 * bound : 0, least = -0.9 * bound;
  const int64_t reach = kernel / 2;
  std::vector<double> logits;
  for (int64_t row = 0; row < kernel; ++row)
    for (int64_t column = 0; column < kernel; ++column) {
      const auto dx = double(column - reach), dy = double(row - reach);
      double logit = top - (dx * dx + dy * dy) / (2 * sigma * sigma);
      if (bound > 0) {
        logit = std::max(logit, least);
        logit /= 1 - std::abs(logit) / bound;  // the inverse of the bound
      }
      logits.push_back(logit);
    }
  return logits;
}

void KernelGenerator::begin_as_gaussian(double sigma) {
  const torch::NoGradGuard no_gradient;
  const int64_t size = std::lround(std::sqrt(double(taps_)));
  const std::vector<double> logits = gaussian_logits(size, sigma, bound_);
  Tensor bias = weights().biases.back();
  for (int64_t tap = 0; tap < taps_; ++tap) bias[tap] = logits[size_t(tap)];
}

void initialise(Network& network, uint64_t seed) {
  const torch::NoGradGuard no_gradient;
  const NetworkConfig& config = network.config();
  const std::set<std::string> outputs = output_weights(network);
  const double slope = network_traits(config.name).in_powers ? kRecurrentSlope : kLeakySlope;
  for (auto& entry : network.named_parameters()) {
    Tensor& parameter = entry.value();
    if (parameter.dim() < 2) {
      parameter.zero_();
      continue;
    }
    const bool he = config.initialisation == "he" && outputs.count(entry.key()) == 0;
    fill_uniform(parameter, entry.key(), float(bound_of(parameter, he, slope)), seed);
  }
  for (const auto& module : network.modules(/*include_self=*/false)) {
    if (auto* modulation = dynamic_cast<Modulation*>(module.get())) modulation->initialise();
    if (auto* rejection = dynamic_cast<Rejection*>(module.get())) rejection->initialise();
    if (auto* history = dynamic_cast<History*>(module.get())) history->initialise();
    if (auto* stage = dynamic_cast<SuperResolution*>(module.get())) stage->begin_without_checkerboard();
    if (config.initial_kernel == 0) continue;
    if (auto* denoiser = dynamic_cast<LightKpcn*>(module.get()))
      denoiser->begin_as_gaussian(config.initial_kernel);
    if (auto* generator = dynamic_cast<KernelGenerator*>(module.get()))
      generator->begin_as_gaussian(config.initial_kernel);
  }
  if (config.initial_kernel > 0) network.begin_sharp();
}

}  // namespace ld
