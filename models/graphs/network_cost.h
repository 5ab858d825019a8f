// What a network computes, counted instead of timed.
#pragma once

#include <cstdint>
#include <string>

#include "models/network_config.h"

namespace ld {

/// Multiply-adds of one forward pass over one frame, by stage. The one definition of it:
///   - every weight of a fully connected network counts once for each sample, layer or pixel that passes
///     through it, every weight of a convolution once for each pixel of its output (rows and columns that the
///     U-net pads to included); biases, activations, pools and upsampling do not count;
///   - the context features are counted as an input of every sample and layer, as the 1x1 convolutions of
///     [MH20] appendix B have them. The operators compute that part once a pixel, so they do fewer;
///   - what weighs or mixes filtered light (rejection, modulation) counts as filtering;
///   - a filter counts one for each tap, channel and source, the sum of weights being a channel too.
/// A training step is three times that (the products backward with the weights and with the activations),
/// less the gradient of the features, which nobody needs: training().
struct NetworkCost {
  double reducer = 0, unet = 0, partitioner = 0, kernel_generator = 0, filtering = 0;
  double first_layer = 0;  // the part of `reducer` that has no gradient towards its input
  double total() const { return reducer + unet + partitioner + kernel_generator + filtering; }
  double training() const { return 3 * total() - first_layer; }
};

/// The sum over the operators of its graph. Throws UsageError as check_network().
NetworkCost multiply_adds(const NetworkConfig& config, int64_t spp, int64_t height, int64_t width);

}  // namespace ld
