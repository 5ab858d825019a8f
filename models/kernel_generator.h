// Kernel generator ([MH20] section 3 and appendix B): a filter kernel for each pixel of each layer.
#pragma once

#include "models/fully_connected.h"
#include "models/network_config.h"

namespace ld {

/// layer embeddings [B, N, E, H, W], context [B, C, H, W] -> kernel logits [B, N, K*K, H, W], tap order as in
/// ops/kernel_splat.h, which exponentiates them.
class KernelGenerator : public FullyConnected {
 public:
  explicit KernelGenerator(const NetworkConfig& config) : FullyConnected(widths(config), LastLayer::linear) {}

 private:
  static std::vector<int64_t> widths(const NetworkConfig& config) {
    std::vector<int64_t> widths = config.kernel_generator;
    widths.insert(widths.begin(), config.sample_reducer.back() + config.unet.context);
    widths.push_back(config.kernel_size * config.kernel_size);
    return widths;
  }
};

}  // namespace ld
