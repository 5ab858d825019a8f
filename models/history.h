// History: what the frames before have left, as one more layer in front of those of the present frame.
#pragma once

#include <torch/torch.h>

#include "models/fully_connected_module.h"
#include "models/network.h"

namespace ld {

/// One surface a pixel, out of the samples that are valid: of these the one of the lower median encoded
/// depth, the first of equals (as sequence/surface_guides.h has it).
struct PixelSurfaces {
  torch::Tensor flow;  // [B, 2, H, W] pixels; infinite where there is none, 0 if the network does not read it
  torch::Tensor surface;  // [B, 4, H, W] encoded depth and normal; zeros for what the network does not read
  torch::Tensor drawn;    // [B, 1, H, W] 1 where there is a valid sample
};
PixelSurfaces pixel_surfaces(const NetworkInput& input, const NetworkConfig& config);

/// What frames leave, `light` H of C channels and how many frames it counts for, n, is warped to where its
/// surfaces are now (ops/warp.h, with guides). With F the light of the present frame,
///   k = n e^g / (1 + n e^g),   light = F + k (t H - F),   n' = min(1 / ((1 - k)^2 + k^2 / n), 32),
/// t = min(1, 2 sum F / sum H), sums over the first three channels, 0 / 0 is 1, and k = 0, n' = 1 where there
/// is no history. A logit g of 0 everywhere is the mean over all frames: F counts for one, H for n. n' is how
/// many frames of independent noise would be as steady. g is learnt from the context and from [r, s, 1 / n]:
/// with d = H - F and t = H + F of the first three channels,
///   r = mean |d| / t,   s = mean |sum d| / sum t,   the sums over 5x5 pixels that have a history,
/// means over the channels; 0 / 0 is 0. Noise cancels in the sums of s, light that has changed does not. t
/// and what the gate looks at are held fixed: no gradient goes through it. t is for what no gate can tell by
/// the light around: one bright sample at the silhouette of a lamp would be handed on for many frames. The
/// result lies between F and t H, so that nothing grows however long a sequence is; without a history it is
/// F, bit for bit.
class History : public torch::nn::Module {
 public:
  explicit History(const NetworkConfig& config);

  /// The light of this frame [B, C, H, W] with that of the state, which becomes what this frame leaves:
  /// "light" [B, C, H, W], "frames" [B, 1, H, W], "surface" [B, 4, H, W]. A pixel without samples leaves
  /// nothing (0 frames). Throws Error for a state that does not fit.
  torch::Tensor remembered(const torch::Tensor& light, const torch::Tensor& context,
                           const NetworkInput& input, const NetworkConfig& config, NetworkState& state) const;

  /// Weights to begin with: g = -1 - 20 s, which lets go where the light has changed.
  void initialise();

 private:
  std::shared_ptr<FullyConnected> gate_;
};

}  // namespace ld
