// Included once for every instruction set: the names that all kernels use for Highway's vectors, and what
// their products share.
#if defined(LD_VECTORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LD_VECTORS_INL_H_
#undef LD_VECTORS_INL_H_
#else
#define LD_VECTORS_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>
#include <type_traits>

#include "ops/kernels/constants.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;
using D = hn::ScalableTag<float>;
using V = hn::Vec<D>;

HWY_INLINE int64_t lanes() {
  return int64_t(hn::Lanes(D()));
}

HWY_INLINE V leaky_relu(D d, V x, float slope = float(kLeakySlope)) {
  return hn::Max(x, hn::Mul(x, hn::Set(d, slope)));
}

// Accumulators of a product: outputs x vectors of pixels, as many as leave registers for the operands. 32
// registers with AVX-512, 16 before.
constexpr bool kManyRegisters = HWY_TARGET <= HWY_AVX3 || HWY_ARCH_ARM;
constexpr int kOutputs = kManyRegisters ? 8 : 4;
constexpr int kVectors = 3;

/// body(number, first) for all of `count` outputs: kOutputs at a time, then 4, 2 and 1; `number` is a
/// constant.
template <class Body>
HWY_INLINE void in_blocks(int64_t count, const Body& body) {
  int64_t first = 0;
  for (; first + kOutputs <= count; first += kOutputs) body(std::integral_constant<int, kOutputs>(), first);
  if (kOutputs > 4 && first + 4 <= count) {
    body(std::integral_constant<int, 4>(), first);
    first += 4;
  }
  if (first + 2 <= count) {
    body(std::integral_constant<int, 2>(), first);
    first += 2;
  }
  if (first < count) body(std::integral_constant<int, 1>(), first);
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#endif
