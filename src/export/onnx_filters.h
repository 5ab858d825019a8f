// The filters of ops/kernel_splat.h and ops/kernel_gather.h in standard ONNX operators.
#pragma once

#include <limits>

#include "export/onnx_graph.h"
#include "ops/kernels/constants.h"

namespace ld {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
/// What logits are bounded by.
constexpr float kLargestLogit = -kLowestLogit;

/// logits [B, N, K*K, H, W], log_n [B, N, 1, H, W], values [B, N, channels, H, W] -> [B, N, channels, H, W],
/// or [B, channels, H, W] with one mean over all N where `joint`. The maths of composed::kernel_splat
/// (ops/composition.h): softmax weights at the destination.
///
/// A row of K taps is filtered at a time, to the largest exponent that arrives and the sums relative to it;
/// the K results of a pixel are put together at the end. So the graph has some twenty nodes for a kernel row
/// instead of ten for each of the K*K taps, and no tensor but the logits has K*K planes.
Value onnx_splat(OnnxGraph& g, const Value& logits, const Value& log_n, const Value& values, int64_t kernel,
                 int64_t channels, bool joint);

/// logits [B, 1, K*K, H, W], log_n [B, 1, H, W], values [B, channels, H, W] -> [B, channels, H, W].
Value onnx_gather(OnnxGraph& g, const Value& logits, const Value& log_n, const Value& values, int64_t kernel,
                  int64_t channels);

}  // namespace ld
