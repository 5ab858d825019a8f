// Numbers of the operators that their kernels, their compositions and their ONNX form share.
#pragma once

#include <limits>

namespace ld {

/// Of leaky ReLU, below 0.
constexpr double kLeakySlope = 0.01;

/// The lowest value that a logit counts as: differences of a few of them stay finite.
constexpr float kLowestLogit = std::numeric_limits<float>::lowest() / 4;

/// Values so large that a sum of them could overflow are summed as this part of themselves.
constexpr double kOverflowScale = 1.0 / (1 << 20);

}  // namespace ld
