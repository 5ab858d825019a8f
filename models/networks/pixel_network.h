// The networks on pixel aggregates ([MH20] section 5 and appendix B): mean and variance of the features enter
// the sample reducer, one filter a pixel works on the mean radiance.
#pragma once

#include "models/networks/context_network.h"

namespace ld {

/// All but the filter.
class PixelNetwork : public ContextNetwork {
 protected:
  explicit PixelNetwork(const NetworkConfig& config);

  /// What the filter reads of some rows.
  struct Pixels {
    torch::Tensor log_n;       // log of what a pixel's sending counts for, -inf without samples [B, 1, H, W]
    torch::Tensor radiance;    // the mean of its samples, in radiance_channels() [B, C, H, W]
    torch::Tensor embedding;   // [B, 1, E, H, W]
    torch::Tensor context;     // C_xy [B, C, H, W]
    torch::Tensor modulators;  // undefined without demodulation

    friend std::vector<torch::Tensor*> tensors_of(Pixels& p) {
      return {&p.log_n, &p.radiance, &p.embedding, &p.context, &p.modulators};
    }
  };

 public:
  int64_t memory_bytes(int64_t samples, int64_t height, int64_t width) const override;

 private:
  torch::Tensor denoise(const InputSource& input) override;
  Kernels make_kernels(const InputSource& input) override;
  Pixels pixels_of_rows(const InputSource& input, const Context& context, int64_t begin, int64_t end) const;
  Context make_pixel_context(const InputSource& input) const;
  int64_t sample_row_bytes(const InputSource& input) const;
  int64_t row_bytes(const PictureSize& size) const;

  /// Filtered radiance [B, C, H, W], from at most kernel_size / 2 pixels away. `first_row` as in
  /// ops/generated_filter.h.
  virtual torch::Tensor filter(const Pixels& pixels, int64_t first_row) const = 0;

  /// The logits of its kernels [B, 1, K*K, H, W].
  virtual torch::Tensor logits(const Pixels& pixels) const = 0;
};

}  // namespace ld
