// What passes from one frame of a sequence to the next.
#pragma once

#include <vector>

#include "frame/frame.h"

namespace ld {

/// The values of Graph::state that a frame has left, [C, H, W] each. Empty where nothing comes before.
using FrameState = std::vector<Image>;

}  // namespace ld
