#include "frame/half_rows.h"

#include <Imath/half.h>

#include <algorithm>

#include "frame/half_range.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "frame/half_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Halves = hn::Rebind<hwy::float16_t, Floats>;
using Bits = hn::Rebind<uint16_t, Floats>;

void widen(const uint16_t* half_bits, float* values, size_t count) {
  const Floats floats;
  const size_t lanes = hn::Lanes(floats);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes)
    hn::StoreU(hn::PromoteTo(floats, hn::BitCast(Halves(), hn::LoadU(Bits(), half_bits + i))), floats,
               values + i);
  for (; i < count; ++i) {
    Imath::half value;
    value.setBits(half_bits[i]);
    values[i] = value;
  }
}

void narrow(const float* values, uint16_t* half_bits, size_t count) {
  size_t i = 0;
#if HWY_TARGET <= HWY_AVX2  // without the instruction, Highway truncates
  const Floats floats;
  const size_t lanes = hn::Lanes(floats);
  const auto low = hn::Set(floats, -kHalfMax), high = hn::Set(floats, kHalfMax);
  for (; i + lanes <= count; i += lanes) {
    const auto bounded = hn::Min(hn::Max(hn::LoadU(floats, values + i), low), high);
    hn::StoreU(hn::BitCast(Bits(), hn::DemoteTo(Halves(), bounded)), Bits(), half_bits + i);
  }
#endif
  for (; i < count; ++i) half_bits[i] = Imath::half(std::clamp(values[i], -kHalfMax, kHalfMax)).bits();
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(widen);
HWY_EXPORT(narrow);

void half_to_float(const uint16_t* half_bits, float* values, size_t count) {
  HWY_DYNAMIC_DISPATCH(widen)(half_bits, values, count);
}

void float_to_half(const float* values, uint16_t* half_bits, size_t count) {
  HWY_DYNAMIC_DISPATCH(narrow)(values, half_bits, count);
}

}  // namespace ld
#endif
