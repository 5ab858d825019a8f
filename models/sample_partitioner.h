// Sample partitioner ([MH20] section 3, eq. 1 and appendix B): how much of a sample belongs to each layer.
#pragma once

#include "models/fully_connected_module.h"
#include "models/network_config.h"

namespace ld {

/// embeddings [B, S, E, H, W], context [B, C, H, W] -> logits of w_xys^l [B, S, layers, H, W]; the softmax
/// over layers is ops/partition.h.
class SamplePartitioner : public FullyConnected {
 public:
  explicit SamplePartitioner(const NetworkConfig& config)
      : FullyConnected(widths(config), LastLayer::linear) {}

 private:
  static std::vector<int64_t> widths(const NetworkConfig& config) {
    std::vector<int64_t> widths = config.sample_partitioner;
    widths.insert(widths.begin(), config.sample_reducer.back() + config.unet.context);
    widths.push_back(config.layers);
    return widths;
  }
};

}  // namespace ld
