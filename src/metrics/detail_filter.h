// The Laplacian of a Gaussian: what of a picture is fine detail. The 15x15 kernel of sigma 1.5 that HFEN, the
// high-frequency error norm, uses (Ravishankar and Bresler, "MR image reconstruction from highly undersampled
// k-space data by dictionary learning", IEEE Transactions on Medical Imaging 30(5), 2011).
#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace ld {

constexpr int kDetailWindow = 15;
constexpr std::size_t kDetailTaps = std::size_t{kDetailWindow} * kDetailWindow;
constexpr double kDetailSigma = 1.5;

/// G (r^2 - 2 s^2) / s^4 with G a Gaussian whose weights sum to 1, less its mean, so that the sum is 0; rows
/// from the top.
const std::array<double, kDetailTaps>& detail_kernel();

/// A plane [height, width] through the kernel, where the whole window lies inside: [height - 14, width - 14];
/// empty for smaller planes.
std::vector<double> fine_detail(const std::vector<double>& plane, int width, int height);

}  // namespace ld
