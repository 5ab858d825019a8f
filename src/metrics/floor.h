// How far a reference is itself from the picture that it stands for: no score against it means more than
// this.
#pragma once

#include "frame/frame.h"

namespace ld {

/// Of each metric of the registry, what a half of a reference scores against the mean of both, averaged over
/// the two: `first` and `second` are independent estimates of the same picture from as many samples each.
///
/// With A and B for them, A - (A + B) / 2 = (A - B) / 2 has the mean 0 and the variance that the noise of
/// (A + B) / 2 has. A half is therefore as far from the mean of both as that is from its limit, in the mean
/// over the noise, and so are their scores, to the first order in the noise: relMSE is a quarter of the
/// halves' squared difference over their squared mean, SMAPE half of their difference, PSNR 6.02 dB more than
/// one half scores against the other. For SSIM, too, noise of this size on one side costs to the first order
/// the same whether it stands on the one picture or on the other. What both halves miss, a bias or a light
/// that neither found, is not in it. Equal halves have the best score: 0, 0, 1, infinity.
///
/// Empty where a half holds a NaN or an infinity. Errors otherwise: metrics/image_pair.h.
ReferenceFloor reference_floor(const Image& first, const Image& second);

}  // namespace ld
