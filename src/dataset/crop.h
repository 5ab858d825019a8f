// A crop of a packed frame, augmented and encoded, in one pass: each tile is read once, and stays in the
// processor's cache until its pixels are where a network wants them.
#pragma once

#include <string>
#include <vector>

#include "dataset/augmentation.h"
#include "dataset/packed_frame.h"

namespace ld {

/// Where a crop goes: planes of result_height x result_width floats, all of which are written.
struct CropPlanes {
  float* features;         // [samples, channels of the features, H, W] encoded (frame/encoding.h)
  float* radiance;         // [samples, 3, H, W] linear
  float* valid;            // [samples, 1, H, W] 1 or 0; where 0, features and radiance are 0
  float* reference;        // [3, H, W] linear
  float* noisy = nullptr;  // [3, H, W] linear, or nothing
};

/// `features` in the network's order, all held by the frame; of the frame's samples only those in `samples`.
/// With `targets`, the mean radiance of these samples takes the place of the reference; a pixel in which none
/// of them is valid keeps the frame's reference. The mean of the samples in `noisy` goes to that plane
/// likewise. Throws Error when the crop does not lie inside the frame or a feature or a sample is not held.
void read_crop(const PackedFrame& frame, const Augmentation& augmentation,
               const std::vector<std::string>& features, const CropPlanes& planes,
               const SampleList& samples = {}, const SampleList& targets = {}, const SampleList& noisy = {});

}  // namespace ld
