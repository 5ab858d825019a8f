#include "models/network.h"

#include "models/parameters.h"

namespace ld {

torch::Tensor Network::forward(NetworkInput input) {
  check_input(input, config_);
  // Admitted at once: strips that overlap would go through it more than once.
  const int64_t height = input.features.size(3);
  input = admit(WholeInput(std::move(input))).rows(0, height);
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
  check_input(input, config_);
  const int64_t height = input.features.size(3);
  return make_kernels(WholeInput(admit(WholeInput(std::move(input))).rows(0, height)));
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
