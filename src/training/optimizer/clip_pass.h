// A batch of clips through a network.
#pragma once

#include <torch/torch.h>

#include "dataset/input_tensors.h"
#include "models/network.h"

namespace ld {

/// All frames of the batch denoised, folded as they are: [B T, 3, H, W]. A network that remembers takes the
/// frames of all clips in their order, from no state at the first; gradients go back through up to
/// `truncation` frames, 0: through all (back-propagation through time). One that does not takes them all at
/// once.
torch::Tensor denoise_clips(Network& network, NetworkInput input, int64_t clip, int64_t truncation = 0);

/// Frame `f` of each of the clips, [B, ...].
NetworkInput frame_of_clips(const NetworkInput& input, int64_t clip, int64_t f);

}  // namespace ld
