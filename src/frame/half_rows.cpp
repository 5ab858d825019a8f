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

/// 16 bytes at a time: their sums in four steps, and the sum of all before, to which only one addition leads
/// from block to block.
void sum_up(uint8_t* bytes, size_t count) {
  uint8_t before = 128;  // the first byte is no difference
  size_t i = 0;
#if HWY_TARGET != HWY_SCALAR
  const hn::FixedTag<uint8_t, 16> block;
  const auto offset = hn::Set(block, 128), last = hn::Set(block, 15);
  auto all_before = hn::Set(block, before);
  for (; i + 16 <= count; i += 16) {
    auto sum = hn::Sub(hn::LoadU(block, bytes + i), offset);
    sum = hn::Add(sum, hn::ShiftLeftBytes<1>(sum));
    sum = hn::Add(sum, hn::ShiftLeftBytes<2>(sum));
    sum = hn::Add(sum, hn::ShiftLeftBytes<4>(sum));
    sum = hn::Add(sum, hn::ShiftLeftBytes<8>(sum));
    hn::StoreU(hn::Add(sum, all_before), block, bytes + i);
    all_before = hn::Add(all_before, hn::TableLookupBytes(sum, last));
  }
  before = hn::GetLane(all_before);
#endif
  for (; i < count; ++i) bytes[i] = before = static_cast<uint8_t>(before + bytes[i] - 128);
}

void join_and_widen(const uint8_t* low, const uint8_t* high, float* values, size_t count) {
  const Floats floats;
  const Bits bits;
  const hn::Rebind<uint8_t, Floats> bytes;
  const size_t lanes = hn::Lanes(floats);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    const auto joined = hn::Or(hn::PromoteTo(bits, hn::LoadU(bytes, low + i)),
                               hn::ShiftLeft<8>(hn::PromoteTo(bits, hn::LoadU(bytes, high + i))));
    hn::StoreU(hn::PromoteTo(floats, hn::BitCast(Halves(), joined)), floats, values + i);
  }
  for (; i < count; ++i) {
    Imath::half value;
    value.setBits(static_cast<uint16_t>(low[i] | high[i] << 8));
    values[i] = value;
  }
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(widen);
HWY_EXPORT(narrow);
HWY_EXPORT(sum_up);
HWY_EXPORT(join_and_widen);

void half_to_float(const uint16_t* half_bits, float* values, size_t count) {
  HWY_DYNAMIC_DISPATCH(widen)(half_bits, values, count);
}

void float_to_half(const float* values, uint16_t* half_bits, size_t count) {
  HWY_DYNAMIC_DISPATCH(narrow)(values, half_bits, count);
}

void undo_differences(uint8_t* bytes, size_t count) {
  HWY_DYNAMIC_DISPATCH(sum_up)(bytes, count);
}

void split_half_to_float(const uint8_t* low, const uint8_t* high, float* values, size_t count) {
  HWY_DYNAMIC_DISPATCH(join_and_widen)(low, high, values, count);
}

}  // namespace ld
#endif
