// PixelGather with a splat in place of the gather: the kernel of a pixel weighs what it sends to its
// neighbours, so that a pixel with a firefly can keep it to itself. Network name "pixel_splat".
#pragma once

#include "models/pixel_network.h"
#include "ops/generated_filter.h"

namespace ld {

class PixelSplatNetwork : public PixelNetwork {
 public:
  explicit PixelSplatNetwork(const NetworkConfig& config) : PixelNetwork(config) {}

 private:
  torch::Tensor filter(const FullyConnectedWeights& generator, const torch::Tensor& embedding,
                       const torch::Tensor& context, const torch::Tensor& log_n,
                       const torch::Tensor& radiance, int64_t first_row) const override {
    return generated_splat(generator, embedding, context, log_n.unsqueeze(1), radiance.unsqueeze(1),
                           first_row)
        .squeeze(1);
  }
};

}  // namespace ld
