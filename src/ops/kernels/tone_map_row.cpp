#include "ops/kernels/tone_map_row.h"

#include <algorithm>
#include <limits>

#include "core/tone_map.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ops/kernels/tone_map_row.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

// Behind them, or it is there for one instruction set alone.
#include <hwy/contrib/math/math-inl.h>

#include "ops/kernels/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

HWY_INLINE V tone_mapped(D d, V x) {
  const V y = hn::Log1p(d, hn::Min(hn::Max(x, hn::Zero(d)), hn::Set(d, std::numeric_limits<float>::max())));
  const V root = hn::Exp(d, hn::Mul(hn::Log(d, hn::Max(y, hn::Set(d, kSrgbLinearTo<float>))),
                                    hn::Set(d, 1 / kSrgbExponent<float>)));
  const V bent = hn::MulSub(hn::Set(d, kSrgbScale<float>), root, hn::Set(d, kSrgbOffset<float>));
  return hn::IfThenElse(hn::Le(y, hn::Set(d, kSrgbLinearTo<float>)),
                        hn::Mul(y, hn::Set(d, kSrgbSlope<float>)), bent);
}

void tone_map_pixels(const float* HWY_RESTRICT x, float* HWY_RESTRICT out, int64_t count) {
  const D d;
  int64_t i = 0;
  for (; i + lanes() <= count; i += lanes()) hn::StoreU(tone_mapped(d, hn::LoadU(d, x + i)), d, out + i);
  if (i == count) return;
  HWY_ALIGN float rest[HWY_MAX_BYTES / sizeof(float)] = {};
  std::copy_n(x + i, count - i, rest);
  hn::Store(tone_mapped(d, hn::Load(d, rest)), d, rest);
  std::copy_n(rest, count - i, out + i);
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(tone_map_pixels);

void tone_map_row(const float* x, float* out, int64_t count) {
  HWY_DYNAMIC_DISPATCH(tone_map_pixels)(x, out, count);
}

}  // namespace ld
#endif
