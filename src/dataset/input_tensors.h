// Frames to tensors and back: frames as files hold them for inference, crops of packed ones for training and
// validation.
#pragma once

#include <torch/torch.h>

#include <memory>
#include <string>
#include <vector>

#include "dataset/crop.h"
#include "frame/frame.h"
#include "models/network.h"

namespace ld {

/// Encodes the named features (frame/schema.h) and stacks the frames to a batch. Frames with fewer samples
/// than the largest are filled with samples that are not valid. Throws Error when the sizes differ or there
/// is no sample.
NetworkInput make_network_input(const std::vector<Frame>& frames, const std::vector<std::string>& features);

/// B clips of T frames, folded: [B T, ...], clip after clip, the frames of each in their order. So a network
/// that keeps nothing from frame to frame trains on clips as on so many single frames.
struct Batch {
  NetworkInput input;
  torch::Tensor reference;   // [B T, 3, H, W] linear
  int64_t clip = 1;          // T
  torch::Tensor noisy = {};  // [B T, 3, H, W] linear: samples that the network does not see; or undefined

  /// The same memory as [B, T, ...], of any of these tensors.
  torch::Tensor by_clip(const torch::Tensor& folded) const { return folded.unflatten(0, {-1, clip}); }
};

/// A crop, the frame that it is of, and which of the frame's samples it reads.
struct FrameCrop {
  std::shared_ptr<const PackedFrame> frame;
  Augmentation augmentation;
  SampleList samples = {};
  SampleList targets = {};  // whose mean takes the place of the reference; none: the frame's reference
  SampleList noisy = {};    // whose mean is Batch::noisy; none in all crops of a batch: there is none

  size_t sample_count() const { return samples.empty() ? static_cast<size_t>(frame->spp) : samples.size(); }
};

/// Reads the crops (dataset/crop.h) of clips of so many frames, filled up with samples that are not valid as
/// above. Runs on the calling thread alone. Throws Error when their sizes differ, there is none, or the last
/// clip is not whole.
Batch make_batch(const std::vector<FrameCrop>& crops, const std::vector<std::string>& features,
                 int64_t clip = 1);

/// [3, H, W] to and from a tensor.
torch::Tensor to_tensor(const Image& image);
Image to_image(const torch::Tensor& tensor);

}  // namespace ld
