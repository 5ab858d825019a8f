// What filters may be handed: values and weights of pixels made safe to sum.
#pragma once

#include <torch/torch.h>

namespace ld {

struct SplatSources {
  torch::Tensor log_n;   // -inf where log_n or a value of that pixel was not finite
  torch::Tensor values;  // times `scale`; 0 where log_n is -inf for that reason
  double scale;          // a power of two, 1 unless values are so large that a sum of them could overflow
};

/// log_n [..., H, W], values [..., C, H, W]. Differentiable. Costs two reductions where all is finite.
SplatSources finite_sources(const torch::Tensor& log_n, const torch::Tensor& values);

}  // namespace ld
