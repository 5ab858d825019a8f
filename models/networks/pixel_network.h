// The networks on pixel aggregates ([MH20] section 5 and appendix B): mean and variance of the features enter
// the sample reducer, one kernel a pixel filters the mean radiance.
#pragma once

#include "models/kernel_generator.h"
#include "models/networks/context_network.h"
#include "ops/generated_filter.h"

namespace ld {

/// What both share.
class PixelNetwork : public ContextNetwork {
 protected:
  explicit PixelNetwork(const NetworkConfig& config);

 public:
  int64_t memory_bytes(int64_t samples, int64_t height, int64_t width) const override;

 private:
  torch::Tensor denoise(const InputSource& input) override;
  Kernels make_kernels(const InputSource& input) override;
  int64_t row_bytes(const PictureSize& size) const;

  /// embedding [B, 1, E, H, W], context [B, C, H, W], log_n [B, H, W] (0, or -inf for a pixel without
  /// samples), radiance [B, 3, H, W] -> [B, 3, H, W]. `first_row` as in ops/generated_filter.h.
  virtual torch::Tensor filter(const FullyConnectedWeights& generator, const torch::Tensor& embedding,
                               const torch::Tensor& context, const torch::Tensor& log_n,
                               const torch::Tensor& radiance, int64_t first_row) const = 0;

  std::shared_ptr<KernelGenerator> kernel_generator_;
};

/// PixelGather of [MH20] section 5, after Bako et al. 2017 without albedo demodulation: the kernel of a pixel
/// weighs what it receives from its neighbours. Network name "pixel_gather".
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

/// PixelGather with a splat in place of the gather: the kernel of a pixel weighs what it sends to its
/// neighbours, so that a pixel with a firefly can keep it to itself. Network name "pixel_splat".
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
