#include "ops/expect_tensor.h"

#include <fmt/ranges.h>

#include <cmath>

#include "core/error.h"

namespace ld {

void expect_tensor(const char* what, const char* layout, const torch::Tensor& tensor,
                   std::initializer_list<int64_t> expected, torch::ScalarType type) {
  if (!tensor.defined()) fail("{} is missing, expected {}", what, layout);
  if (tensor.scalar_type() != type)
    fail("{} has element type {}, expected {}", what, toString(tensor.scalar_type()), toString(type));
  bool fits = tensor.dim() == int64_t(expected.size());
  for (int64_t axis = 0; fits && axis < tensor.dim(); ++axis) {
    const int64_t size = expected.begin()[axis];
    fits = size == kAnySize || size == tensor.size(axis);
  }
  if (fits) return;
  std::vector<std::string> sizes;
  for (const int64_t size : expected) sizes.push_back(size == kAnySize ? "any" : std::to_string(size));
  fail("{} has shape [{}], expected {} = [{}]", what, fmt::join(tensor.sizes(), ", "), layout,
       fmt::join(sizes, ", "));
}

int64_t expect_odd_kernel(const char* what, int64_t taps) {
  const int64_t kernel = std::lround(std::sqrt(double(taps)));
  if (kernel % 2 == 0 || kernel * kernel != taps)
    fail("{}: logits have {} taps, expected the square of an odd kernel size", what, taps);
  if (kernel > 31) fail("{}: logits have {} taps, expected kernels of at most 31 x 31", what, taps);
  return kernel;
}

torch::ScalarType floating_type(const char* what, const torch::Tensor& tensor) {
  if (!tensor.defined()) fail("{} is missing", what);
  const torch::ScalarType type = tensor.scalar_type();
  if (type != torch::kFloat32 && type != torch::kFloat64)
    fail("{} has element type {}, expected Float or Double", what, toString(type));
  return type;
}

}  // namespace ld
