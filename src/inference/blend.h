// Towards the truth: a denoised picture keeps an error of its own however many samples there are, the mean of
// the samples does not. Blended by estimates of both errors, the result is denoised where there are few
// samples and converges where there are many. After Firmino, Frisvad and Jensen 2022, "Progressive Denoising
// of Monte Carlo Rendered Images", with two halves of the samples in place of a network that is trained for
// it: the error of a picture denoised from one half shows in its distance from the other half's mean, whose
// noise is independent and known.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "frame/frame.h"
#include "frame/sample_arrays.h"

namespace ld {

/// Side of the windows over which the errors are estimated, pixels.
constexpr int kBlendWindow = 7;
/// A picture's own error counts as far as it is surely there: so many standard errors of its estimate are
/// taken off, and kBlendCaution / n more with n samples a pixel, of which even the standard error is a guess.
constexpr double kBlendConfidence = 0.5, kBlendCaution = 64;

/// Whether the frame has the two samples a pixel that halves need.
bool can_blend(const Frame& frame);

/// Every other sample, from the first or the second on.
Frame half_of(const Frame& frame, int first);

/// The same where the samples lie, which must stay there: `features` as far as the frame has them. To be
/// moved, not copied.
struct HalfInPlace {
  std::vector<uint8_t> valid;
  SampleArrays arrays;
};
HalfInPlace half_in_place(const Frame& frame, int first, const std::vector<std::string>& features);

/// What blend_with_mean() takes at most, with its three pictures and what half_in_place() copies.
int64_t blend_bytes(const Frame& frame);

struct Blended {
  Image picture;  // [3, H, W]
  Image weight;   // [1, H, W]: a, of the denoised picture
};

/// a d + (1 - a) y, with y the mean of the samples and a = v / (v + b^2) a pixel: the least expected error of
/// such a mixture. Both are means over kBlendWindow^2 pixels and the channels, weighted by 1 / (h^2 + 0.01)
/// for a denoised half h: v the variance of y, from the samples' spread within the pixel, and the pixel's own
/// where that is larger (one bright sample would stay as a speck); b^2 the squared error of a denoised half,
/// the mean over both of (h - z)^2 - var(z) with z the mean of the other half, less some of that estimate's
/// standard errors, at least 0. Those come from how far the two halves' estimates lie apart in each pixel,
/// not from how they differ between pixels: a denoiser may be wrong in a few pixels alone. The result is
/// averaged over such windows once more, lest noise come in where chance made it large in one. Where v is 0,
/// a is 0. A pixel in which one half is not valid says nothing of either. `denoised` is of all samples;
/// `first` and `second` of half_of(frame, 0) and half_of(frame, 1). Finite for all finite pictures. Throws
/// Error when the sizes differ or can_blend() is false.
Blended blend_with_mean(const Frame& frame, const Image& denoised, const Image& first, const Image& second);

}  // namespace ld
