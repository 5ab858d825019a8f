// Mean and variance over a pixel's valid items, for a row of pixels (models/sample_statistics.h).
#pragma once

#include <algorithm>

#include "runtime/row_window.h"

namespace ld {

/// What each valid item of a pixel counts for in a mean.
inline void shares(const RowWindow& valid, int64_t y, float* __restrict share) {
  const int64_t width = valid.width;
  std::fill_n(share, width, 0.0f);
  for (int64_t s = 0; s < valid.planes; ++s) {
    const float* __restrict drawn = valid.row(y, s);
    for (int64_t x = 0; x < width; ++x) share[x] += drawn[x];
  }
  for (int64_t x = 0; x < width; ++x) share[x] = 1 / std::max(share[x], 1.0f);
}

/// out = the mean of value(row_of(item), x).
template <class RowOf, class Value>
void mean_of(const RowWindow& valid, int64_t y, const float* __restrict share, const RowOf& row_of,
             const Value& value, float* __restrict out) {
  const int64_t width = valid.width;
  std::fill_n(out, width, 0.0f);
  for (int64_t s = 0; s < valid.planes; ++s) {
    const float* __restrict drawn = valid.row(y, s);
    const float* __restrict from = row_of(s);
    for (int64_t x = 0; x < width; ++x) out[x] += drawn[x] * share[x] * value(from, x);
  }
}
template <class RowOf>
void mean_of(const RowWindow& valid, int64_t y, const float* share, const RowOf& row_of, float* out) {
  mean_of(
      valid, y, share, row_of, [](const float* from, int64_t x) { return from[x]; }, out);
}

/// Mean and population variance of the numbers at row_of(item), in two passes. `missed`: a row of scratch.
template <class RowOf>
void mean_and_variance(const RowWindow& valid, int64_t y, const float* share, const RowOf& row_of,
                       float* missed, float* mean, float* variance) {
  mean_of(valid, y, share, row_of, mean);
  // The mean of many values is rounded; what it misses is the mean of the rest.
  mean_of(
      valid, y, share, row_of, [=](const float* from, int64_t x) { return from[x] - mean[x]; }, missed);
  mean_of(
      valid, y, share, row_of,
      [=](const float* from, int64_t x) {
        const float rest = from[x] - mean[x] - missed[x];
        return rest * rest;
      },
      variance);
  for (int64_t x = 0; x < valid.width; ++x) mean[x] += missed[x];
}

}  // namespace ld
