// Which of a network's two stages learns from what: the four training schemes of Arjun Arora and others
// (github.com/Arjun-Arora/GettingStartedWithRTXRayTracing, experiments 4a to 4d).
#pragma once

#include <torch/torch.h>

#include "dataset/input_tensors.h"
#include "losses/clip_loss.h"
#include "models/network.h"
#include "training/run/config.h"

namespace ld {

/// Whether a training by this scheme needs Batch::noisy.
bool needs_noisy(const OptimizerConfig& config);

/// With F the first stage of x, G the second one, y1 a noisy picture of other random numbers than x's
/// (Batch::noisy) and y the reference, the loss of a batch is
///   L(G(z), y) + w L(F(x), y1),
///   scheme      separate (4a)  concurrent (4b)              end_to_end (4c)  two_heads (4d)
///   z           y1             F(x), no gradient through it F(x)             F(x)
///   w           1              1                            0                head_weight
/// The stages share no parameter, so that with the first two each learns from its own term as in a training
/// of its own. A network of one stage, and end_to_end, take the loss of the picture alone; the batch's input
/// is used up. Throws Error for a batch without what the scheme needs.
torch::Tensor batch_loss(Network& network, Batch& batch, const ClipLoss& loss, const OptimizerConfig& config);

}  // namespace ld
