// Parameters of modules: with memory, or as shapes alone.
#pragma once

#include <torch/torch.h>

namespace ld {

/// While one lives, what this thread makes with new_parameter() has a shape and no memory (LibTorch's "meta"
/// device): for those who count what a network holds, or what a damaged file says that it holds.
class ShapesOnly {
 public:
  ShapesOnly() : before_(current()) { current() = true; }
  ~ShapesOnly() { current() = before_; }
  ShapesOnly(const ShapesOnly&) = delete;
  ShapesOnly& operator=(const ShapesOnly&) = delete;
  static bool& current() {
    static thread_local bool shapes_only = false;
    return shapes_only;
  }

 private:
  bool before_;
};

/// A parameter that a module registers, of zeros. Every module makes its parameters here.
inline torch::Tensor new_parameter(at::IntArrayRef sizes) {
  return torch::zeros(sizes, ShapesOnly::current() ? torch::kMeta : torch::kCPU);
}

}  // namespace ld
