// Shape checks shared by the operators: one clear line instead of an abort deep inside a kernel.
#pragma once

#include <torch/torch.h>

#include <initializer_list>
#include <limits>

namespace ld {

constexpr int64_t kAnySize = -1;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Throws Error unless `tensor` is a defined tensor of the `expected` sizes (kAnySize fits all) with the
/// type of `like`. `what` names it ("kernel_splat: logits"), `layout` spells its axes ("[B, N, K*K, H, W]").
void expect_tensor(const char* what, const char* layout, const torch::Tensor& tensor,
                   std::initializer_list<int64_t> expected, torch::ScalarType type);

/// The size K of a kernel with `taps` = K*K taps; throws Error, naming `what`, unless K is odd and 1 to 31.
int64_t expect_odd_kernel(const char* what, int64_t taps);

/// float32 or float64; throws Error for anything else, naming `what`.
torch::ScalarType floating_type(const char* what, const torch::Tensor& tensor);

}  // namespace ld
