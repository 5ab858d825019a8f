// Whether a network that learns from noisy frames alone becomes better: its error on frames that are held
// out, against samples of theirs that it does not see, block by block beside the error of the network that it
// began with. The samples' noise is in both and in no difference between them.
#pragma once

#include <torch/torch.h>

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/input_tensors.h"
#include "metrics/statistics.h"

namespace ld {

/// Side of the blocks, pixels: what a network does wrong is alike within a few pixels, and the blocks are to
/// be independent.
constexpr int kBlockSide = 32;
/// Fewer blocks say nothing.
constexpr int kFewestBlocks = 16;
/// Above this share of the variance that two samples of a pixel have in common, they are no independent
/// samples: the target then holds noise that the input shows.
constexpr double kLargestCorrelation = 0.05;

/// How many blocks a picture has.
int64_t blocks_of(int width, int height);

/// Of each block the mean over pixels and channels of ((d - y)^2 - u) / (s^2 + v + kRelativeL2Epsilon): d the
/// denoised picture [1, 3, H, W], y the mean of `targets` samples, u its variance, s the mean of the input's
/// samples and v their variance about their pixel's mean, both over 5x5 pixels; u is that variance in the
/// pixel itself, divided by `targets`. In expectation this is the squared error against the truth, but for an
/// offset that the samples decide and not the network; it may be below 0. s and v depend on neither the
/// target nor the network; v, of the size of the targets' own noise, keeps fireflies from deciding. Finite
/// for all finite radiances.
std::vector<double> block_errors(const torch::Tensor& denoised, const Batch& batch, int targets);

/// The correlation of two samples of a pixel that the spread within the pixel cannot show, from how far the
/// samples lie from a denoised picture: (c(0) - c(1)) / (c(0) - c(1) + v). c(k) is the mean product of the
/// residuals of two different samples, k pixels apart in x, which the picture's own error adds to alike at 0
/// and at 1; v is the variance of the samples about their pixel's mean. All are weighted as above. 0 for
/// independent samples, 1 for one sample repeated. nullopt for fewer than two samples, and without noise.
std::optional<double> sample_correlation(const torch::Tensor& denoised, const Batch& batch);

/// Of the errors of a network and of the one at the beginning.
struct HeldOutComparison {
  double beginning = 0, now = 0;  // mean over the blocks
  Interval difference;            // now - beginning, with kConfidence

  bool better() const { return difference.high < 0; }
  /// What is to become small: the largest difference that is likely. 0 for the beginning.
  double score() const { return difference.high; }
};

/// Throws Error when the two do not have as many blocks, or fewer than two.
HeldOutComparison compare_blocks(const std::vector<double>& beginning, const std::vector<double>& now);

/// RUN/held_out.csv: the beginning's errors, every bit of them. Reading throws Error for a missing or damaged
/// file.
void write_beginning(const std::filesystem::path& run, const std::vector<double>& errors);
std::vector<double> read_beginning(const std::filesystem::path& run);

}  // namespace ld
