// The example of docs/extending.md: a network that predicts for each pixel how much of its mean to keep, the
// rest of which comes from a Gaussian blur that nothing is learnt of.
#include "graph/operators.h"
#include "models/fully_connected_module.h"
#include "models/networks/pixel_network.h"
#include "models/networks/registry.h"
#include "ops/expect_tensor.h"
#include "ops/generated_filter.h"

namespace ld {
namespace {

using torch::Tensor;

/// With L the mean radiance of a pixel's samples, E its embedding and C its context:
///   o = k L + (1 - k) G[L],   k = sigmoid(w . [E, C] + b), 0 for a pixel without samples,
/// G the mean of the pixels with samples under a Gaussian of kernel_size taps a side, whose deviation is a
/// sixth of that.
class PixelBlendNetwork : public PixelNetwork {
 public:
  explicit PixelBlendNetwork(const NetworkConfig& config)
      : PixelNetwork(config),
        blend_(register_module(
            "blend", std::make_shared<FullyConnected>(
                         std::vector<int64_t>{config.sample_reducer.back() + config.unet.context, 1},
                         LastLayer::linear))) {}

 private:
  Tensor filter(const Pixels& pixels) const override {
    // A kernel generator that sees two zeros and has the kernel in its biases.
    const Tensor bias = gaussian(pixels), nothing = at::zeros_like(pixels.log_n);
    const FullyConnectedWeights generator = {{at::zeros({bias.size(0), 2}, bias.options())}, {bias}};
    const Tensor blurred =
        generated_gather(generator, nothing.unsqueeze(2), nothing, pixels.log_n.squeeze(1), pixels.radiance);
    const Tensor k = kept(pixels);
    return k * pixels.radiance + (1 - k) * blurred;
  }

  Tensor logits(const Pixels& pixels) const override {
    const Tensor taps = at::softmax(gaussian(pixels), 0).view({1, 1, -1, 1, 1}),
                 k = kept(pixels).unsqueeze(2);  // [B, 1, 1, H, W]
    Tensor kernels = (1 - k) * taps;
    kernels.narrow(2, taps.size(2) / 2, 1).add_(k);
    return kernels.log();
  }

  /// k [B, 1, H, W].
  Tensor kept(const Pixels& pixels) const {
    const Tensor logit = with_bounded_gradient(blend_->forward(pixels.embedding, pixels.context).squeeze(2));
    return at::sigmoid(logit).masked_fill(pixels.log_n.eq(-kInfinity), 0);
  }

  /// Logits of the taps [K*K].
  Tensor gaussian(const Pixels& pixels) const {
    return torch::tensor(graph::Blur{config().kernel_size}.logits(), torch::kFloat64)
        .to(pixels.radiance.options());
  }

  std::shared_ptr<FullyConnected> blend_;
};

}  // namespace

std::shared_ptr<Network> make_pixel_blend_network(const NetworkConfig& config) {
  return std::make_shared<PixelBlendNetwork>(config);
}

}  // namespace ld
