// A batch of clips through a network, and back.
#pragma once

#include <torch/torch.h>

#include "dataset/input_tensors.h"
#include "losses/clip_loss.h"
#include "models/network.h"

namespace ld {

/// How gradients go back through a clip (back-propagation through time).
struct ClipPassOptions {
  int64_t truncation = 0;  // through up to so many frames; 0: through all
  /// Of networks that remember: the activations of one frame exist at a time, because each frame is run again
  /// when its gradient's turn comes. The same gradient to rounding, in a third more time.
  bool recompute = false;
};

/// All frames of the batch and what a loss compares of them (Network::compare()), folded as they are: [B T,
/// 3, H, W]. A network that remembers takes the frames of all clips in their order, from no state at the
/// first; one that does not takes them all at once.
Compared compare_clips(Network& network, Batch batch, int64_t truncation = 0);

/// Adds the gradient of `share` times the loss of the batch to those of the weights; returns share times the
/// loss.
double add_gradient(Network& network, Batch batch, const ClipLoss& loss, double share,
                    const ClipPassOptions& options = {});

/// Frame `f` of each of the clips, [B, ...].
NetworkInput frame_of_clips(const NetworkInput& input, int64_t clip, int64_t f);

}  // namespace ld
