// What happens to the samples of a tile of pixels beside networks and partition, float32, for every SIMD
// width (Highway). Planes begin at whole vectors; `pixels` is a multiple of kPixelStep. Free of LibTorch.
#pragma once

#include <array>

#include "ops/kernels/dense.h"

namespace ld {

/// share = 1 / how many items of a pixel are valid (1 or 0); 1 where none is.
void valid_shares(PlanarRow valid, int64_t items, int64_t pixels, float* share);

/// The mean over the valid items of numbers of which plane i belongs to item i; 0 where none is valid.
void mean_of_items(PlanarRow values, PlanarRow valid, const float* share, int64_t items, int64_t pixels,
                   float* mean);

/// That and the population variance, in two passes (models/sample_statistics.h).
void moments_of_items(PlanarRow values, PlanarRow valid, const float* share, int64_t items, int64_t pixels,
                      float* mean, float* variance);

/// planes *= mask, each of `count`.
void mask_planes(PlanarTarget planes, int64_t count, const float* mask, int64_t pixels);

/// What demodulation divides by and up to which radiance (models/network_numbers.h).
struct DemodulationLimits {
  float no_reflectance, least_reflectance, most_reflectance, largest_radiance;
};
/// One sample: albedo [3] and specular [3], either of which may be missing, and radiance [3] -> what it is
/// divided by [3], and the divided and the plain radiance [6].
void demodulate(const DemodulationLimits& limits, PlanarRow albedo, PlanarRow specular, PlanarRow radiance,
                int64_t pixels, PlanarTarget divisors, PlanarTarget forms);

/// The mean of variance / mean^2 over three channels; a mean of 0 counts as 1.
void relative_variance(PlanarRow means, PlanarRow variances, int64_t pixels, float* relative);

/// to = log_n - most * sigmoid(logit).
void reject(const float* log_n, const float* logit, float most, int64_t pixels, float* to);

/// exp(-falloff * the mean over the 3x3 pixels that are there) at pixels [x, x + count) of a row.
struct RowsAround {
  std::array<const float*, 3> rows;  // above, at and below; null where there is none
  int64_t width;
};
void steadiness(const RowsAround& values, float falloff, int64_t x, int64_t count, float* to);

/// factors = means [3] and beta = sigmoid(logit), 0 where no mean is above 0.
void modulation_factors(PlanarRow means, const float* logit, int64_t pixels, PlanarTarget factors);

/// out = plain + beta * (mean * divided - plain), plain where a channel of it is beyond `largest`; of further
/// parts the same mean in the form that no sign and size overflows; what is beyond whole colours stays.
struct ModulationTile {
  PlanarRow filtered;  // divided [3], plain [3], then the divided coloured parts and all plain ones
  PlanarRow factors;   // [4]
  int64_t parts;       // channels beyond the radiance's
  float largest;
  int64_t pixels;
  PlanarTarget out;  // [3 + parts]
};
void modulate(const ModulationTile& tile);

}  // namespace ld
