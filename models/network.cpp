#include "models/network.h"

#include <fmt/ranges.h>

#include <functional>
#include <map>

#include "core/error.h"
#include "models/layer_network.h"
#include "models/optimized_network.h"
#include "models/pixel_gather_network.h"
#include "models/pixel_splat_network.h"
#include "models/sample_splat_network.h"

namespace ld {
namespace {

using Maker = std::function<std::shared_ptr<Network>(const NetworkConfig&)>;

template <class T>
std::shared_ptr<Network> make(const NetworkConfig& config) {
  return std::make_shared<T>(config);
}

/// A new network is one line here, one in check_network.cpp and one file beside this one.
const std::map<std::string, Maker>& registry() {
  static const std::map<std::string, Maker> networks = {
      {"layer", make<LayerNetwork>},
      {"optimized", make<OptimizedNetwork>},
      {"pixel_gather", make<PixelGatherNetwork>},
      {"pixel_splat", make<PixelSplatNetwork>},
      {"sample_splat", make<SampleSplatNetwork>},
  };
  return networks;
}

}  // namespace

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

std::shared_ptr<Network> make_network(const NetworkConfig& config) {
  check_network(config);
  return registry().at(config.name)(config);
}

}  // namespace ld
