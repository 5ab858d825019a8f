// Frames to tensors and back: the one way into a network, for training, validation and inference.
#pragma once

#include <torch/torch.h>

#include <string>
#include <vector>

#include "frame/frame.h"
#include "models/network.h"

namespace ld {

/// Encodes the named features (frame/schema.h) and stacks the frames to a batch. Frames with fewer samples
/// than the largest are filled with samples that are not valid. Throws Error when the sizes differ or there
/// is no sample.
NetworkInput make_network_input(const std::vector<Frame>& frames, const std::vector<std::string>& features);

/// [3, H, W] to and from a tensor.
torch::Tensor to_tensor(const Image& image);
Image to_image(const torch::Tensor& tensor);

}  // namespace ld
