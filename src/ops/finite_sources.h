// What filters may be handed: values and weights of pixels made safe to sum.
#pragma once

#include <torch/torch.h>

namespace ld {

struct FiniteSources {
  torch::Tensor log_n;   // -inf where log_n or a value of that pixel was not finite
  torch::Tensor values;  // times `scale`; 0 where log_n is -inf for that reason
  double scale;          // kOverflowScale, or 1 unless values are so large that a sum of them could overflow
};

/// log_n [..., H, W], values [..., C, H, W]. Differentiable. Costs two reductions where all is finite.
FiniteSources finite_sources(const torch::Tensor& log_n, const torch::Tensor& values);

/// A filter's result on scaled values, scaled back.
torch::Tensor unscaled(const torch::Tensor& filtered, const FiniteSources& sources);

/// The gradient of a filter's result, contiguous, bounded so that no product with a difference of two values
/// overflows: only where values are so large that they carry no picture.
torch::Tensor bounded_gradient(const torch::Tensor& gradient, const torch::Tensor& values);

}  // namespace ld
