// PixelGather of [MH20] section 5, after Bako et al. 2017 without albedo demodulation: the kernel of a pixel
// weighs what it receives from its neighbours. Network name "pixel_gather".
#pragma once

#include "models/pixel_network.h"
#include "ops/generated_filter.h"

namespace ld {

class PixelGatherNetwork : public PixelNetwork {
 public:
  explicit PixelGatherNetwork(const NetworkConfig& config) : PixelNetwork(config) {}

 private:
  torch::Tensor filter(const FullyConnectedWeights& generator, const torch::Tensor& embedding,
                       const torch::Tensor& context, const torch::Tensor& log_n,
                       const torch::Tensor& radiance, int64_t /*first_row*/) const override {
    return generated_gather(generator, embedding, context, log_n, radiance);
  }
};

}  // namespace ld
