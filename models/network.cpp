#include "models/network.h"

#include "models/parameters.h"

namespace ld {

/// Admitted at once: strips that overlap would go through it more than once.
NetworkInput Network::admit_whole(NetworkInput input) {
  check_input(input, config_);
  const torch::Device here = device();
  for (torch::Tensor* t : {&input.features, &input.radiance, &input.valid}) *t = t->to(here);
  const int64_t height = input.features.size(3);
  return admit(WholeInput(std::move(input))).rows(0, height);
}

torch::Tensor Network::forward(NetworkInput input) {
  input = admit_whole(std::move(input));
  const double largest =
      at::GradMode::is_enabled() ? input.radiance.detach().max().item<double>() : 0;  // finite now
  torch::Tensor output = denoise(WholeInput(std::move(input)));
  if (largest > 1e15 && output.requires_grad()) {
    const double bound = 1e30 / largest;
    output.register_hook([bound](const torch::Tensor& gradient) { return gradient.clamp(-bound, bound); });
  }
  return output;
}

torch::Tensor Network::forward(const InputSource& input) {
  return denoise(admit(input));
}

Kernels Network::kernels(NetworkInput input) {
  return make_kernels(WholeInput(admit_whole(std::move(input))));
}

std::shared_ptr<Network> make_network_shapes(const NetworkConfig& config) {
  const ShapesOnly no_memory;
  return make_network(config);
}

int64_t parameter_count(const Network& network) {
  int64_t count = 0;
  for (const torch::Tensor& parameter : network.parameters()) count += parameter.numel();
  return count;
}

}  // namespace ld
