// The layers at halved resolutions, for the hierarchical kernels of [MH20] section 6.
#pragma once

#include <torch/torch.h>

#include <vector>

#include "ops/partition.h"

namespace ld {

struct PyramidLevel {
  Partition layers;      // ratios and log n as in ops/partition.h; E_l is the mean over pixels with samples
  torch::Tensor pixels;  // [B, 1, H, W] how many pixels of full resolution with samples lie in this one
};

/// The layers at full resolution, 1/2, 1/4, ...; level i has ceil(H / 2^i) x ceil(W / 2^i) pixels. Four
/// pixels p become one with n = mean of n(p) and, in ratios, L / n = sum_p softmax_p(log n) (L / n)(p), alike
/// for transmittance; opacity is left out: products with n, which may underflow, are never formed. Pixels
/// that an odd border lacks count as pixels without samples. Differentiable.
std::vector<PyramidLevel> layer_pyramid(const Partition& layers, int64_t levels);

}  // namespace ld
