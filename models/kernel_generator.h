// Kernel generator ([MH20] section 3 and appendix B): a filter kernel for each pixel of each layer.
#pragma once

#include "models/fully_connected.h"
#include "models/network_config.h"

namespace ld {

/// embeddings [B, N, E, H, W], context [B, C, H, W] -> kernel logits [B, N, K*K, H, W], tap order as in
/// ops/kernel_splat.h, which exponentiates them. `further` outputs may follow the taps (the level weights of
/// section 6).
class KernelGenerator : public FullyConnected {
 public:
  KernelGenerator(const NetworkConfig& config, int64_t context, int64_t further = 0)
      : FullyConnected(widths(config, context, further), LastLayer::linear) {}

  /// The network of outputs [first, first + count) alone.
  FullyConnectedWeights outputs(int64_t first, int64_t count) const {
    FullyConnectedWeights part = weights();
    part.weights.back() = part.weights.back().narrow(0, first, count);
    part.biases.back() = part.biases.back().narrow(0, first, count);
    return part;
  }

 private:
  static std::vector<int64_t> widths(const NetworkConfig& config, int64_t context, int64_t further) {
    std::vector<int64_t> widths = config.kernel_generator;
    widths.insert(widths.begin(), config.sample_reducer.back() + context);
    widths.push_back(config.kernel_size * config.kernel_size + further);
    return widths;
  }
};

}  // namespace ld
