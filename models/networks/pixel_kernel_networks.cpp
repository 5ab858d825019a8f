// The networks on pixels with a generated kernel for each pixel.
#include "models/kernel_generator.h"
#include "models/networks/pixel_network.h"
#include "models/networks/registry.h"
#include "ops/generated_filter.h"

namespace ld {
namespace {

using torch::Tensor;

class PixelKernelNetwork : public PixelNetwork {
 protected:
  explicit PixelKernelNetwork(const NetworkConfig& config)
      : PixelNetwork(config),
        kernel_generator_(register_module("kernel_generator",
                                          std::make_shared<KernelGenerator>(config, config.unet.context))) {}

  std::shared_ptr<KernelGenerator> kernel_generator_;

 private:
  Tensor logits(const Pixels& pixels) const override {
    return kernel_generator_->logits(pixels.embedding, pixels.context);
  }
};

/// PixelGather of [MH20] section 5, after Bako et al. 2017 without albedo demodulation: the kernel of a pixel
/// weighs what it receives from its neighbours.
class PixelGatherNetwork : public PixelKernelNetwork {
 public:
  explicit PixelGatherNetwork(const NetworkConfig& config) : PixelKernelNetwork(config) {}

 private:
  Tensor filter(const Pixels& pixels) const override {
    return generated_gather(kernel_generator_->kernels(), pixels.embedding, pixels.context,
                            pixels.log_n.squeeze(1), pixels.radiance);
  }
};

/// PixelGather with a splat in place of the gather: the kernel of a pixel weighs what it sends to its
/// neighbours, so that a pixel with a firefly can keep it to itself.
class PixelSplatNetwork : public PixelKernelNetwork {
 public:
  explicit PixelSplatNetwork(const NetworkConfig& config) : PixelKernelNetwork(config) {}

 private:
  Tensor filter(const Pixels& pixels) const override {
    return generated_splat(kernel_generator_->kernels(), pixels.embedding, pixels.context, pixels.log_n,
                           pixels.radiance.unsqueeze(1))
        .squeeze(1);
  }
};

}  // namespace

std::shared_ptr<Network> make_pixel_gather_network(const NetworkConfig& config) {
  return std::make_shared<PixelGatherNetwork>(config);
}

std::shared_ptr<Network> make_pixel_splat_network(const NetworkConfig& config) {
  return std::make_shared<PixelSplatNetwork>(config);
}

}  // namespace ld
