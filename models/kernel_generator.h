// Kernel generator ([MH20] section 3 and appendix B): a filter kernel for each pixel of each layer.
#pragma once

#include "models/fully_connected_module.h"
#include "models/network_config.h"

namespace ld {

/// What logits of kernel x kernel taps are, before their bound, for a Gaussian of this deviation (pixels):
/// -d^2 / (2 sigma^2) at distance d, as far as a bound lets them fall.
std::vector<double> gaussian_logits(int64_t kernel, double sigma, double bound);

/// embeddings [B, N, E, H, W], context [B, C, H, W] -> kernel logits [B, N, K*K, H, W], tap order as in
/// ops/kernel_splat.h, which exponentiates them. `further` outputs may follow the taps (the level weights of
/// section 6).
class KernelGenerator : public FullyConnected {
 public:
  KernelGenerator(const NetworkConfig& config, int64_t context, int64_t further = 0)
      : FullyConnected(widths(config, context, further), LastLayer::linear),
        taps_(config.kernel_size * config.kernel_size),
        bound_(config.logit_bound) {}

  /// What makes the logits of the taps, within their bound.
  FullyConnectedWeights kernels() const {
    FullyConnectedWeights part = outputs(0, taps_);
    part.bound = bound_;
    return part;
  }

  /// embedding [B, N, E, H, W], context [B, C, H, W] -> the taps' logits [B, N, K*K, H, W].
  torch::Tensor logits(const torch::Tensor& embedding, const torch::Tensor& context) const {
    return fully_connected(embedding, context, kernels(), /*activate_last=*/false);
  }

  /// What makes the further outputs.
  FullyConnectedWeights further() const { return outputs(taps_, weights().weights.back().size(0) - taps_); }

  /// Sets the last bias so that, before anything is learnt, all kernels are such a Gaussian.
  void begin_as_gaussian(double sigma);

 private:
  FullyConnectedWeights outputs(int64_t first, int64_t count) const {
    FullyConnectedWeights part = weights();
    part.weights.back() = part.weights.back().narrow(0, first, count);
    part.biases.back() = part.biases.back().narrow(0, first, count);
    return part;
  }
  static std::vector<int64_t> widths(const NetworkConfig& config, int64_t context, int64_t further) {
    std::vector<int64_t> widths = config.kernel_generator;
    widths.insert(widths.begin(), config.sample_reducer.back() + context);
    widths.push_back(config.kernel_size * config.kernel_size + further);
    return widths;
  }

  int64_t taps_;
  double bound_;
};

}  // namespace ld
