#include "models/demodulation.h"

#include "frame/schema.h"
#include "models/network_numbers.h"
#include "models/sample_statistics.h"

namespace ld {

using torch::Tensor;

Tensor demodulator(const Tensor& features, const NetworkConfig& config) {
  Tensor sum;
  for (const char* name : {"albedo", "specular"}) {
    const int64_t first = first_channel(config.features, name);
    if (first < 0) continue;
    const Tensor reflectance = features.narrow(2, first, 3);
    sum = sum.defined() ? sum + reflectance : reflectance;
  }
  const Tensor none = sum.detach().le(kNoReflectance).all(2, /*keepdim=*/true);
  return sum.clamp(kLeastReflectance, kMostReflectance).masked_fill(none, 1);
}

Tensor demodulated(const Tensor& radiance, const Tensor& demodulator) {
  return at::cat({radiance.clamp_max(kLargestDemodulated) / demodulator, radiance}, 2);
}

Tensor modulators(const Tensor& demodulator, const Tensor& valid) {
  const Tensor statistics = sample_statistics(demodulator, valid).squeeze(1);
  const Tensor mean = statistics.narrow(1, 0, 3), variance = statistics.narrow(1, 3, 3);
  const Tensor relative = variance / mean.square().masked_fill(mean.detach().eq(0), 1);
  return at::cat({mean, relative.mean(1, /*keepdim=*/true)}, 1);
}

Modulation::Modulation(const NetworkConfig& config)
    : weight_(register_module(
          "weight", std::make_shared<FullyConnected>(std::vector<int64_t>{1 + config.unet.context, 1},
                                                     LastLayer::linear))) {}

Tensor Modulation::factors(const Tensor& modulators, const Tensor& context) const {
  const Tensor mean = modulators.narrow(1, 0, 3);
  const Tensor variance = at::avg_pool2d(modulators.narrow(1, 3, 1), 3, 1, 1, /*ceil_mode=*/false,
                                         /*count_include_pad=*/false);
  const Tensor steady = at::exp(-kSteadyFalloff * variance);
  const Tensor beta = at::sigmoid(weight_->forward(steady.unsqueeze(1), context).squeeze(1));
  return at::cat({mean, beta.masked_fill(mean.detach().amax(1, true).eq(0), 0)}, 1);
}

Tensor Modulation::apply(const Tensor& filtered, const Tensor& factors) {
  const Tensor plain = filtered.narrow(1, 3, 3);
  const Tensor beyond = plain.detach().amax(1, true).gt(kLargestModulated);
  const Tensor beta = factors.narrow(1, 3, 1).masked_fill(beyond, 0);
  return plain + beta * (factors.narrow(1, 0, 3) * filtered.narrow(1, 0, 3) - plain);
}

void Modulation::initialise() {
  const torch::NoGradGuard no_gradient;
  Tensor weights = weight_->weights().weights[0], bias = weight_->weights().biases[0];
  weights.zero_();
  weights.narrow(1, 0, 1).fill_(4);
  bias.fill_(-2);
}

}  // namespace ld
