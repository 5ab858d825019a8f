// Colours whose channels lie side by side, taken apart (Highway, chosen at run time).
#pragma once

#include <array>
#include <cstddef>

namespace ld {

/// rgbrgb... of `count` pixels to three planes.
void split_colours(const float* colours, size_t count, const std::array<float*, 3>& planes);

}  // namespace ld
