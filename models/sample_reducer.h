// Sample reducer ([MH20] section 3 and appendix B): features of a sample to its embedding.
#pragma once

#include "frame/schema.h"
#include "models/fully_connected.h"
#include "models/network_config.h"

namespace ld {

/// features [B, S, F, H, W] -> embeddings E_xys [B, S, E, H, W].
class SampleReducer : public FullyConnected {
 public:
  explicit SampleReducer(const NetworkConfig& config)
      : FullyConnected(widths(config), LastLayer::activated) {}

 private:
  static std::vector<int64_t> widths(const NetworkConfig& config) {
    std::vector<int64_t> widths = config.sample_reducer;
    widths.insert(widths.begin(), channel_count(config.features));
    return widths;
  }
};

}  // namespace ld
