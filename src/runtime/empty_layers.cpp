#include "runtime/empty_layers.h"

#include <algorithm>

#include "runtime/parallel.h"

namespace ld {
namespace {

constexpr int64_t kBlock = SplatSkips::kBlock;

/// Of each block for which it is asked: whether all of its pixels in a row are `value`.
void keep_equal(const float* row, float value, int64_t width, int64_t blocks, uint8_t* asked) {
  for (int64_t b = 0; b < blocks; ++b) {
    if (asked[b] == 0) continue;
    const float* const first = row + b * kBlock;
    int others = 0;
    if (width - b * kBlock >= kBlock)
      for (int64_t x = 0; x < kBlock; ++x) others |= int(first[x] != value);  // vectors take no early end
    else
      for (int64_t x = 0; x < width - b * kBlock; ++x) others |= int(first[x] != value);
    asked[b] = uint8_t(others == 0);
  }
}

/// a &= b
void and_row(uint8_t* a, const uint8_t* b, int64_t blocks) {
  for (int64_t i = 0; i < blocks; ++i) a[i] = uint8_t(a[i] & b[i]);
}

}  // namespace

EmptyLayers::EmptyLayers(const FilterShape& shape, int64_t rows)
    : shape_(shape),
      opaque_(shape, rows),
      transparent_(shape, rows),
      skips_(shape, rows + 2 * shape.radius()) {}

int64_t EmptyLayers::bytes(const FilterShape& shape, int64_t rows) {
  const EmptyLayers one(shape, rows);
  return one.opaque_.bytes() + one.transparent_.bytes() + one.skips_.bytes();
}

void EmptyLayers::look(const Sources& sources, int64_t first, int64_t last, int threads) {
  constexpr int64_t kWorthThreads = 1 << 15;  // pixels
  if ((last - first) * shape_.width < kWorthThreads) threads = 1;
  first_ = first;
  last_ = last;
  begin_ = std::max<int64_t>(first - shape_.radius(), 0);
  end_ = std::min(last + shape_.radius(), shape_.height);
  parallel_for(threads, last - first, [&](int64_t i, int) { look_at_sources(sources, first + i); });
  parallel_for(threads, end_ - begin_, [&](int64_t i, int) { decide(begin_ + i); });
}

void EmptyLayers::look_at_sources(const Sources& sources, int64_t y) {
  const int64_t colours = shape_.channels - 1, blocks = skips_.blocks();
  const graph::Span& wanted = sources.wanted[size_t(y)];
  for (int64_t l = 0; l + 1 < shape_.layers; ++l) {  // behind the last one there is nothing
    uint8_t *opaque = opaque_.row(l, y - first_), *transparent = transparent_.row(l, y - first_);
    for (int64_t b = 0; b < blocks; ++b)
      opaque[b] = transparent[b] =
          uint8_t(b * kBlock >= wanted.begin && std::min((b + 1) * kBlock, shape_.width) <= wanted.end);
    keep_equal(sources.transmittance.row(y, l), 0, shape_.width, blocks, opaque);
    keep_equal(sources.transmittance.row(y, l), 1, shape_.width, blocks, transparent);
    for (int64_t c = 0; c < colours; ++c)
      keep_equal(sources.light.row(y, l * colours + c), 0, shape_.width, blocks, transparent);
  }
}

void EmptyLayers::decide(int64_t y) {
  const int64_t blocks = skips_.blocks(), radius = shape_.radius();
  for (int64_t l = 0; l < shape_.layers; ++l) std::fill_n(skips_.row(l, y - begin_), blocks, uint8_t{made});
  const int64_t first = std::max<int64_t>(y - radius, 0), last = std::min(y + radius + 1, shape_.height);
  if (first < first_ || last > last_) return;  // other strips' sources reach it
  const int64_t sides = (radius + kBlock - 1) / kBlock;
  std::vector<uint8_t> opaque(static_cast<size_t>(blocks)), transparent(opaque), is_hidden(opaque);
  for (int64_t l = 0; l < shape_.layers; ++l) {
    const bool is_last = l + 1 == shape_.layers;  // which may be hidden alone
    std::fill(opaque.begin(), opaque.end(), uint8_t{1});
    std::fill(transparent.begin(), transparent.end(), uint8_t(is_last ? 0 : 1));
    for (int64_t v = first; v < last && !is_last; ++v) {
      and_row(opaque.data(), opaque_.row(l, v - first_), blocks);
      and_row(transparent.data(), transparent_.row(l, v - first_), blocks);
    }
    const auto all_around = [&](const std::vector<uint8_t>& row, int64_t b) {
      return std::all_of(row.begin() + std::max<int64_t>(b - sides, 0),
                         row.begin() + std::min(b + sides + 1, blocks), [](uint8_t is) { return is != 0; });
    };
    uint8_t* skips = skips_.row(l, y - begin_);
    for (int64_t b = 0; b < blocks; ++b) {
      if (is_hidden[size_t(b)] != 0)
        skips[b] = hidden;
      else if (all_around(transparent, b))
        skips[b] = clear;
      else
        is_hidden[size_t(b)] = uint8_t(all_around(opaque, b));
    }
  }
}

int64_t EmptyLayers::fill(int64_t y, PlanarTarget row) const {
  if (y < begin_ || y >= end_) return 0;
  int64_t pixels = 0;
  for (int64_t l = 0; l < shape_.layers; ++l) {
    const uint8_t* skips = skips_.row(l, y - begin_);
    for (int64_t b = 0; b < skips_.blocks(); ++b) {
      if (skips[b] == made) continue;
      const int64_t x = b * kBlock, count = std::min(kBlock, shape_.width - x);
      for (int64_t c = 0; c < shape_.channels; ++c) {
        const bool passes = c + 1 == shape_.channels && skips[b] == clear;
        std::fill_n(row.plane(l * shape_.channels + c) + x, count, passes ? 1.0f : 0.0f);
      }
      pixels += count;
    }
  }
  return pixels;
}

}  // namespace ld
