// The networks on pixel aggregates ([MH20] section 5 and appendix B): mean and variance of the features enter
// the sample reducer, one filter a pixel works on the mean radiance.
#pragma once

#include "models/networks/context_network.h"

namespace ld {

/// All but the filter.
class PixelNetwork : public ContextNetwork {
 protected:
  explicit PixelNetwork(const NetworkConfig& config);

  /// What the filter reads.
  struct Pixels {
    torch::Tensor log_n;      // log of what a pixel's sending counts for, -inf without samples [B, 1, H, W]
    torch::Tensor radiance;   // the mean of its samples, in all forms that are filtered [B, C, H, W]
    torch::Tensor embedding;  // [B, 1, E, H, W]
    torch::Tensor context;    // C_xy [B, C, H, W]
    std::vector<torch::Tensor> features;  // the context, and what the U-net knows at each coarser level
  };

 private:
  torch::Tensor denoise(const NetworkInput& input, NetworkState& state) override;
  Kernels make_kernels(const NetworkInput& input) override;
  Pixels make_pixels(const NetworkInput& input) const;

  /// Filtered radiance [B, C, H, W].
  virtual torch::Tensor filter(const Pixels& pixels) const = 0;

  /// The logits of its kernels [B, 1, K*K, H, W].
  virtual torch::Tensor logits(const Pixels& pixels) const = 0;
};

}  // namespace ld
