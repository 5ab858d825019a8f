#include "metrics/sequence_difference.h"

#include <cmath>
#include <limits>

namespace ld {
namespace {

size_t tap_index(const BilinearTap& tap, int width) {
  return static_cast<size_t>(tap.y) * static_cast<size_t>(width) + static_cast<size_t>(tap.x);
}

/// Taps of no weight are left out, so that what does not count may be anything.
template <class T>
double lookup(const T* plane, const Reprojection& place, int width) {
  double sum = 0;
  for (const BilinearTap& tap : place.taps)
    if (tap.weight > 0) sum += double{tap.weight} * static_cast<double>(plane[tap_index(tap, width)]);
  return sum;
}

/// Calls use(value index, pixel, e, b) for every channel of the pixels that were seen before; returns how
/// many values there were.
template <class T, class F>
size_t for_each_difference(const TemporalPictures<T>& pictures, const Warp& warp, int width, F&& use) {
  const size_t plane = warp.size(), channels = plane == 0 ? 0 : pictures.now.size() / plane;
  size_t count = 0;
  for (size_t c = 0; c < channels; ++c) {
    const T* const before = pictures.before.data() + c * plane;
    const T* const reference_before = pictures.reference_before.data() + c * plane;
    for (size_t p = 0; p < plane; ++p) {
      if (!warp[p].valid) continue;
      const size_t i = c * plane + p;
      const double change = static_cast<double>(pictures.now[i]) - lookup(before, warp[p], width);
      const double expected =
          static_cast<double>(pictures.reference_now[i]) - lookup(reference_before, warp[p], width);
      use(i, p, change - expected, expected);
      ++count;
    }
  }
  return count;
}

}  // namespace

Warp identity_warp(int width, int height) {
  Warp warp;
  warp.reserve(static_cast<size_t>(width) * static_cast<size_t>(height));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      Reprojection place;
      place.taps[0] = {x, y, 1};
      place.valid = true;
      warp.push_back(place);
    }
  return warp;
}

template <class T>
std::vector<T> warped(const std::vector<T>& before, const Warp& warp, int width) {
  std::vector<T> result(before.size());
  for (size_t i = 0; i < before.size(); ++i) {
    const size_t p = i % warp.size();
    if (warp[p].valid) result[i] = static_cast<T>(lookup(before.data() + (i - p), warp[p], width));
  }
  return result;
}

template <class T>
double temporal_error(TemporalNorm norm, const TemporalPictures<T>& pictures, const Warp& warp, int width) {
  double sum = 0;
  const size_t count = for_each_difference(pictures, warp, width, [&](size_t, size_t, double e, double b) {
    sum += norm == TemporalNorm::squared    ? e * e
           : norm == TemporalNorm::absolute ? std::abs(e)
                                            : std::abs(e) / (std::abs(b) + kTemporalEpsilon);
  });
  return count > 0 ? sum / static_cast<double>(count) : std::numeric_limits<double>::quiet_NaN();
}

template <class T>
void add_temporal_gradient(TemporalNorm norm, const TemporalPictures<T>& pictures, const Warp& warp,
                           int width, double scale, std::vector<T>& now, std::vector<T>& before) {
  const size_t count = for_each_difference(pictures, warp, width, [](size_t, size_t, double, double) {});
  if (count == 0) return;
  const double share = scale / static_cast<double>(count);
  for_each_difference(pictures, warp, width, [&](size_t i, size_t p, double e, double b) {
    const double sign = e > 0 ? 1 : e < 0 ? -1 : 0;
    const double slope = share * (norm == TemporalNorm::squared    ? 2 * e
                                  : norm == TemporalNorm::absolute ? sign
                                                                   : sign / (std::abs(b) + kTemporalEpsilon));
    now[i] += static_cast<T>(slope);
    for (const BilinearTap& tap : warp[p].taps)
      if (tap.weight > 0) before[i - p + tap_index(tap, width)] -= static_cast<T>(slope * double{tap.weight});
  });
}

#define LD_TEMPORAL(T)                                                                                    \
  template std::vector<T> warped(const std::vector<T>&, const Warp&, int);                                \
  template double temporal_error(TemporalNorm, const TemporalPictures<T>&, const Warp&, int);             \
  template void add_temporal_gradient(TemporalNorm, const TemporalPictures<T>&, const Warp&, int, double, \
                                      std::vector<T>&, std::vector<T>&);
LD_TEMPORAL(float)
LD_TEMPORAL(double)
#undef LD_TEMPORAL

}  // namespace ld
