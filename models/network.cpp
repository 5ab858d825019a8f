#include "models/network.h"

#include "core/error.h"
#include "models/demodulation.h"
#include "models/exposure.h"
#include "models/pixel_mean.h"

namespace ld {

NetworkInput Network::admit(NetworkInput input) {
  check_input(input, config_);
  const torch::Device here = device();
  for (torch::Tensor* t : {&input.features, &input.radiance, &input.valid}) *t = t->to(here);
  // That of the samples, which their mean no longer has.
  const torch::Tensor exposure =
      config_.exposure_normalisation ? exposure_of(input.radiance, input.valid) : torch::Tensor();
  input = sanitise(std::move(input), faults_);
  if (config_.means) input = pixel_mean(std::move(input), config_);
  if (exposure.defined()) input = with_exposure(std::move(input), exposure, config_);
  if (config_.demodulation != "none") {
    input.demodulator = demodulator(input.features, config_);
    input.radiance = demodulated(input.radiance, input.demodulator);
  }
  return input;
}

namespace {

/// Where the radiance is so large that a gradient times it could overflow.
void bound_gradient(const torch::Tensor& output, const NetworkInput& input) {
  if (!output.requires_grad()) return;
  const double largest = input.radiance.detach().max().item<double>();  // finite, of an admitted input
  if (largest <= 1e15) return;
  const double bound = 1e30 / largest;
  output.register_hook([bound](const torch::Tensor& gradient) { return gradient.clamp(-bound, bound); });
}

}  // namespace

torch::Tensor Network::forward(NetworkInput input, NetworkState& state) {
  input = admit(std::move(input));
  torch::Tensor output = denoise(input, state);
  bound_gradient(output, input);
  return output;
}

Compared Network::compare(NetworkInput input, const torch::Tensor& reference, NetworkState& state) {
  input = admit(std::move(input));
  Compared compared = predict(input, reference.to(device()), state);
  bound_gradient(compared.predicted, input);
  return compared;
}

Compared Network::predict(const NetworkInput& input, const torch::Tensor& reference, NetworkState& state) {
  const torch::Tensor picture = denoise(input, state);
  return {picture, picture, reference};
}

Stages Network::stages(NetworkInput input, SecondReads reads, const torch::Tensor& given) {
  input = admit(std::move(input));
  return make_stages(input, reads, given.defined() ? given.to(device()) : given);
}

Stages Network::make_stages(const NetworkInput& /*input*/, SecondReads /*reads*/,
                            const torch::Tensor& /*given*/) {
  fail("network '{}' has one stage; 'espcn_kpcn' has two", config_.name);
}

Kernels Network::kernels(NetworkInput input) {
  return make_kernels(admit(std::move(input)));
}

}  // namespace ld
