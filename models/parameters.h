// Parameters of modules: with memory, or as shapes alone.
#pragma once

#include <torch/torch.h>

#include "core/scoped_value.h"

namespace ld {

/// While one lives, what this thread makes with new_parameter() has a shape and no memory (LibTorch's "meta"
/// device): for those who count what a network holds, or what a damaged file says that it holds.
class ShapesOnly : public ScopedValue<ShapesOnly, bool> {
 public:
  ShapesOnly() : ScopedValue(true) {}
};

/// A parameter that a module registers, of zeros. Every module makes its parameters here.
inline torch::Tensor new_parameter(at::IntArrayRef sizes) {
  return torch::zeros(sizes, ShapesOnly::current() ? torch::kMeta : torch::kCPU);
}

}  // namespace ld
