// Which crop of a clip a training step sees, and how it is flipped, turned and exposed ([MH20] section 4).
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/random.h"
#include "dataset/packed_frame.h"

namespace ld {

/// Applied in this order: crop, flip in x (left to right), flip in y (top to bottom), quarter turns
/// counterclockwise as seen by the viewer. Every vector-valued feature (normal, motion vector, lens position)
/// turns with the pixels; the features' frames are in frame/schema.h.
struct Augmentation {
  int x = 0, y = 0, width = 0, height = 0;  // the crop, pixels; must lie inside the frame
  bool flip_x = false, flip_y = false;
  int quarter_turns = 0;                      // 0 to 3
  std::array<float, 3> exposure = {1, 1, 1};  // factors on the channels of the result's radiance, samples
                                              // and reference alike
  std::array<int, 3> colours = {0, 1, 2};     // channel c of every colour is the frame's channel colours[c]
  bool reversed = false;  // time runs backwards: motion over the shutter, and where in it a sample lies
  int last_frame =
      -1;  // the clip stays at this one of its frames, in the order in which they run; -1: at none

  int result_width() const { return quarter_turns % 2 == 0 ? width : height; }
  int result_height() const { return quarter_turns % 2 == 0 ? height : width; }
  TileRange tiles() const { return PackedFrame::tiles_of(x, y, width, height); }
};

struct AugmentationOptions {
  int crop = 128;  // side of the square crops, pixels; less where the frame is smaller
  bool flips = true, rotations = true;
  int candidates = 1;     // positions drawn; one is taken with a probability in proportion to its difficulty
  float exposure = 0;     // stops: radiance is multiplied by 2^u, u uniform in [-exposure, exposure]
  bool colours = false;   // the three channels of all colours alike in any of their six orders
  bool reversal = false;  // half of the clips run backwards in time
  float tint = 0;         // radiance is multiplied by u for each channel, uniform in [0, tint]; 0: not at all
  float stop = 0;         // so large a share of the clips shows one frame
  float freeze = 0;  // so large a share of the clips stays at one of its frames, but not the first or last
  int multiple = 1;  // of columns and rows where crops begin: what 2x2 pixels share stays together
};

/// One for all frames of a clip, which have one size. Uniform in flips and turns, and in position where there
/// is one candidate. The difficulty of a candidate is the sum over the frames; candidates that are all of
/// difficulty 0 are equally likely.
Augmentation random_augmentation(RandomStream& stream, const std::vector<const PackedFrame*>& clip,
                                 const AugmentationOptions& options);

/// The mean of the tiles' difficulties (dataset/packed_frame.h), weighted by how much of each the crop
/// covers.
double crop_difficulty(const PackedFrame& frame, int x, int y, int width, int height);

}  // namespace ld
