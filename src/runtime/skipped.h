// What was left out of a frame's work.
#pragma once

namespace ld {

/// Shares, 0 to 1.
struct Skipped {
  double pixels = 0;   // whose light is even (runtime/light_ranges.h)
  double samples = 0;  // of what networks make of each sample: samples that are the pixel's first again
  double layers = 0;   // of the pixels of filtered layers: those without influence (runtime/empty_layers.h)
};

}  // namespace ld
