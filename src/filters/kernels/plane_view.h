// A picture of planes as kernels gather from it.
#pragma once

#include <cstdint>

namespace ld {

/// Planes of a whole picture: that of row y begins at data[y * row_pitch + plane * pitch].
struct PlaneView {
  const float* data = nullptr;
  int64_t row_pitch = 0, pitch = 0;
};

}  // namespace ld
