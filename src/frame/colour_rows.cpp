#include "frame/colour_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "frame/colour_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

void split(const float* colours, size_t count, const std::array<float*, 3>& planes) {
  const hn::ScalableTag<float> d;
  using V = hn::Vec<decltype(d)>;
  const size_t lanes = hn::Lanes(d);
  size_t i = 0;
  for (; i + lanes <= count; i += lanes) {
    V red, green, blue;
    hn::LoadInterleaved3(d, colours + 3 * i, red, green, blue);
    hn::StoreU(red, d, planes[0] + i);
    hn::StoreU(green, d, planes[1] + i);
    hn::StoreU(blue, d, planes[2] + i);
  }
  for (; i < count; ++i)
    for (size_t c = 0; c < 3; ++c) planes[c][i] = colours[3 * i + c];
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

HWY_EXPORT(split);

void split_colours(const float* colours, size_t count, const std::array<float*, 3>& planes) {
  HWY_DYNAMIC_DISPATCH(split)(colours, count, planes);
}

}  // namespace ld
#endif
