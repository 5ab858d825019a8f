// Demodulation: the filter works on light that the texture of the first hit has been divided out of, and the
// texture comes back sharp (as Bako et al. 2017 and Schied et al. 2017 do for diffuse light). Where surfaces
// mix in a pixel (defocus, movement, edges) its mean texture is noise and belongs to no sample, so that the
// radiance as it is goes through the same kernels beside, and a weight that is learnt for each pixel chooses.
#pragma once

#include <torch/torch.h>

#include "models/fully_connected_module.h"
#include "models/network_config.h"
#include "models/network_input.h"

namespace ld {

/// a_s of every sample [B, S, 3, H, W], from its features [B, S, F, H, W]: albedo + specular (where the
/// network has that feature) within [0.02, 64]; 1 in all channels where there is no reflectance to speak of
/// (no surface, a black one, a lamp), whose radiance then stays as it is.
torch::Tensor demodulator(const torch::Tensor& features, const NetworkConfig& config);

/// Radiance in the two forms that are filtered, [B, S, 6, H, W]: L_s / a_s and L_s. The former of at most
/// 1e35 / a_s, which does not overflow.
torch::Tensor demodulated(const torch::Tensor& radiance, const torch::Tensor& demodulator);

/// What Modulation needs to know of a pixel, [B, 4, H, W]: the mean of a_s over its valid samples, and their
/// relative variance (population, mean over the channels); 0 where there is no valid sample.
torch::Tensor modulators(const torch::Tensor& demodulator, const torch::Tensor& valid);

/// The step after the filter, with F its results:
///   o = beta A F[L / a] + (1 - beta) F[L],   A the pixel's mean a,
///   beta = sigmoid(w . [exp(-12 v), C] + b),
/// v the relative variance of a, averaged over 3x3 pixels, C the context. A pixel without samples has no A
/// and takes beta = 0, as do those whose F[L] is above 1e34. A constant a changes nothing but rounding,
/// whatever beta; a texture a under constant light E, L = a E, comes out as it is where beta = 1.
class Modulation : public torch::nn::Module {
 public:
  explicit Modulation(const NetworkConfig& config);

  /// modulators [B, 4, H, W], context [B, C, H, W] -> A and beta of each pixel, [B, 4, H, W].
  torch::Tensor factors(const torch::Tensor& modulators, const torch::Tensor& context) const;

  /// filtered [B, 6, H, W], factors [B, 4, H, W] -> o [B, 3, H, W].
  static torch::Tensor apply(const torch::Tensor& filtered, const torch::Tensor& factors);

  /// Weights to begin with: beta falls from 0.88 where a does not vary to 0.12, whatever the context.
  void initialise();

 private:
  std::shared_ptr<FullyConnected> weight_;
};

}  // namespace ld
