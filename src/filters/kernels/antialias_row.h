// One row of temporal antialiasing.
#pragma once

#include <array>

#include "filters/kernels/plane_view.h"

namespace ld {

struct AntialiasRow {
  int64_t width = 0, height = 0, y = 0, pitch = 0;
  std::array<const float*, 3> depth{}, flow{}, now{};  // rows y - 1 to y + 1, null outside
  PlaneView before;
  float* out = nullptr;
  float share = 0.1F, deviations = 1;
};

/// The history at p + flow, flow that of the nearest surface among the 3x3 pixels, within mean +- deviations
/// of the 3x3 pixels now; out = lerp(history, now, share) for three planes. Where p + flow lies outside, the
/// pixel as it is.
void antialias_row(const AntialiasRow& row);

}  // namespace ld
