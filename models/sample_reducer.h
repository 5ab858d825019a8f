// Sample reducer ([MH20] section 3 and appendix B): features of a sample to its embedding.
#pragma once

#include "models/fully_connected_module.h"
#include "models/network_config.h"

namespace ld {

/// features [B, S, F, H, W] -> embeddings E_xys [B, S, E, H, W]. F is given, because the networks on pixels
/// feed it two statistics of each feature.
class SampleReducer : public FullyConnected {
 public:
  SampleReducer(const NetworkConfig& config, int64_t inputs)
      : FullyConnected(widths(config, inputs), LastLayer::activated) {}

 private:
  static std::vector<int64_t> widths(const NetworkConfig& config, int64_t inputs) {
    std::vector<int64_t> widths = config.sample_reducer;
    widths.insert(widths.begin(), inputs);
    return widths;
  }
};

}  // namespace ld
