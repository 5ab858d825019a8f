// What OpenEXR does to the bytes of a chunk before it deflates them, undone (Highway, chosen at run time).
#pragma once

#include <cstddef>
#include <cstdint>

namespace ld {

/// From differences of neighbours (plus 128) to the bytes themselves.
void undo_differences(uint8_t* bytes, size_t count);

/// Half floats whose low and high bytes stand apart, to floats; exact.
void split_half_to_float(const uint8_t* low, const uint8_t* high, float* values, size_t count);

}  // namespace ld
