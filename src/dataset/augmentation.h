// Crops, flips and quarter turns of frames. Every vector-valued feature (normal, motion vector, lens
// position) turns with the pixels ([MH20] section 4 augments its training data; the features' frames are in
// frame/schema.h).
#pragma once

#include <Imath/half.h>

#include <cstdint>
#include <vector>

#include "core/random.h"
#include "frame/frame.h"

namespace ld {

/// Applied in this order: crop, flip in x (left to right), flip in y (top to bottom), quarter turns
/// counterclockwise as seen by the viewer.
struct Augmentation {
  int x = 0, y = 0, width = 0, height = 0;  // the crop, pixels; must lie inside the frame
  bool flip_x = false, flip_y = false;
  int quarter_turns = 0;  // 0 to 3
};

/// A frame whose samples are half floats, as they are in the file: what the cache holds.
struct HalfFrame {
  int width = 0, height = 0, spp = 0;
  std::vector<Imath::half> samples;  // [spp, kSampleChannels, height, width]
  std::vector<uint8_t> valid;        // [spp, height, width]
  FrameInfo info;
  size_t bytes() const { return samples.size() * sizeof(Imath::half) + valid.size(); }
};
HalfFrame to_half(const Frame& frame);

/// Throws Error when the crop does not lie inside.
Frame augment(const HalfFrame& frame, const Augmentation& augmentation);
Image augment(const Image& image, const Augmentation& augmentation);

/// A crop of `size` x `size` (less where the frame is smaller), uniform in position, flips and turns.
Augmentation random_augmentation(RandomStream& stream, int width, int height, int size, bool flips,
                                 bool rotations);

}  // namespace ld
