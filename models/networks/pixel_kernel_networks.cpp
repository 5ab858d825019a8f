// The networks on pixels with a generated kernel for each pixel.
#include "models/kernel_generator.h"
#include "models/level_blend.h"
#include "models/networks/layer_pyramid.h"
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

/// The kernels of coarser levels, and what weighs the levels of a pixel. A module of its own, so that the
/// weights of PixelSplat fit a PixelPyramid, which then begins near to it.
class Levels : public torch::nn::Module {
 public:
  explicit Levels(const NetworkConfig& config)
      : logits_(register_module(
            "logits",
            std::make_shared<FullyConnected>(
                std::vector<int64_t>{config.sample_reducer.back() + config.unet.context, config.levels},
                LastLayer::linear))) {
    for (int64_t i = 1; i < config.levels; ++i)
      generators_.push_back(
          register_module("kernel_generator" + std::to_string(i),
                          std::make_shared<KernelGenerator>(config, UNet::feature_channels(config.unet, i))));
  }

  FullyConnected& logits() { return *logits_; }
  const KernelGenerator& generator(size_t level) const { return *generators_[level - 1]; }

 private:
  std::shared_ptr<FullyConnected> logits_;
  std::vector<std::shared_ptr<KernelGenerator>> generators_;  // of half resolution first
};

/// PixelSplat at several resolutions: pixels are halved as the layers of [MH20] section 6 are, splatted at
/// each resolution by kernels of its own, and the pictures blended as there. The reach of a kernel doubles
/// with each level at a quarter of the work, so that what is even over many pixels loses the noise that no
/// kernel of full resolution spans.
class PixelPyramidNetwork : public PixelKernelNetwork {
 public:
  explicit PixelPyramidNetwork(const NetworkConfig& config)
      : PixelKernelNetwork(config), levels_(register_module("levels", std::make_shared<Levels>(config))) {}

  /// lambda_0 = e^3 / (e^3 + levels - 1), whatever the picture.
  void begin_sharp() override {
    const torch::NoGradGuard no_gradient;
    const FullyConnectedWeights& weights = levels_->logits().weights();
    Tensor last = weights.weights.back(), bias = weights.biases.back();
    last.zero_();
    bias.narrow(0, 0, 1).fill_(3);
  }

 private:
  Tensor filter(const Pixels& pixels) const override {
    Partition layer;  // the pixels as the only one
    layer.log_n = pixels.log_n;
    layer.radiance = pixels.radiance.unsqueeze(1);
    layer.embedding = pixels.embedding;
    const std::vector<PyramidLevel> pyramid = layer_pyramid(layer, config().levels);
    std::vector<Tensor> pictures, received;
    for (size_t i = 0; i < pyramid.size(); ++i) {
      const KernelGenerator& generator = i == 0 ? *kernel_generator_ : levels_->generator(i);
      const Partition& level = pyramid[i].layers;
      pictures.push_back(generated_splat(generator.kernels(), level.embedding, pixels.features[i],
                                         level.log_n, level.radiance)
                             .squeeze(1));
      received.push_back(received_from(pyramid[i].pixels, config().kernel_size));
    }
    const Tensor logits =
        with_bounded_gradient(levels_->logits().forward(pixels.embedding, pixels.context).squeeze(1));
    return blend_levels(logits, pictures, received, config().unet);
  }

  std::shared_ptr<Levels> levels_;
};

}  // namespace

std::shared_ptr<Network> make_pixel_gather_network(const NetworkConfig& config) {
  return std::make_shared<PixelGatherNetwork>(config);
}

std::shared_ptr<Network> make_pixel_splat_network(const NetworkConfig& config) {
  return std::make_shared<PixelSplatNetwork>(config);
}

std::shared_ptr<Network> make_pixel_pyramid_network(const NetworkConfig& config) {
  return std::make_shared<PixelPyramidNetwork>(config);
}

}  // namespace ld
