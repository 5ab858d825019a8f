// Pictures of several planes as the filters read them: the rows of all planes of a pixel row lie together.
#pragma once

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// ZeroPages that begin at a cache line: half of the vectors of a row would lie across two otherwise.
template <class T>
struct ZeroLines : ZeroPages<T> {
  static constexpr size_t kLine = 64;
  ZeroLines() = default;
  template <class U>
  ZeroLines(const ZeroLines<U>& /*other*/) noexcept {}
  T* allocate(size_t count) {
    char* const memory = static_cast<char*>(zero_pages(count * sizeof(T) + 2 * kLine, 1));
    char* const line = memory + (2 * kLine - reinterpret_cast<uintptr_t>(memory) % kLine);
    reinterpret_cast<char**>(line)[-1] = memory;
    return reinterpret_cast<T*>(line);
  }
  void deallocate(T* line, size_t /*count*/) noexcept { std::free(reinterpret_cast<char**>(line)[-1]); }
};

/// [height][planes][margin, width, margin] floats. A load may begin up to kMargin floats before a row and end
/// as far behind it: taps beyond the left and right border need no test where the margin holds what counts
/// for nothing (0, or NaN for a surface that equals no other).
class RowPlanes {
 public:
  /// Reach of the widest à-trous level (2 * 2^4) and the rest of a vector, in whole cache lines.
  static constexpr int64_t kMargin = 64;

  RowPlanes() = default;
  RowPlanes(int width, int height, int planes)
      : width_(width),
        height_(height),
        planes_(planes),
        pitch_(odd_lines(width + 2 * kMargin)),
        row_pitch_(odd_lines(pitch_ * planes)),
        memory_(size_t(row_pitch_) * size_t(height)) {}

  int width() const { return width_; }
  int height() const { return height_; }
  int planes() const { return planes_; }
  int64_t pitch() const { return pitch_; }          // from a plane's row to that of the next plane
  int64_t row_pitch() const { return row_pitch_; }  // from a plane's row to its next row
  int64_t floats() const { return int64_t(memory_.size()); }
  bool is(int width, int height, int planes) const {
    return width == width_ && height == height_ && planes == planes_;
  }

  float* row(int64_t y, int plane = 0) { return memory_.data() + y * row_pitch_ + plane * pitch_ + kMargin; }
  const float* row(int64_t y, int plane = 0) const { return const_cast<RowPlanes*>(this)->row(y, plane); }
  float& at(int64_t x, int64_t y, int plane) { return row(y, plane)[x]; }
  float at(int64_t x, int64_t y, int plane) const { return row(y, plane)[x]; }

  /// Sets what lies before and behind the pixels of a plane.
  void fill_margin(int plane, float value) {
    for (int64_t y = 0; y < height_; ++y) {
      std::fill(row(y, plane) - kMargin, row(y, plane), value);
      std::fill(row(y, plane) + width_, row(y, plane) - kMargin + pitch_, value);
    }
  }

 private:
  /// A whole and odd number of cache lines: what lies at one x of all planes and rows then spreads over the
  /// sets of the cache, where powers of two would fall into one.
  static int64_t odd_lines(int64_t floats) { return ((floats + 15) / 16 | 1) * 16; }

  int width_ = 0, height_ = 0, planes_ = 0;
  int64_t pitch_ = 0, row_pitch_ = 0;
  std::vector<float, ZeroLines<float>> memory_;
};

/// Makes `planes` of that size; what it held may stay. Memory that is kept costs no page faults.
inline void resize(RowPlanes& planes, int width, int height, int count) {
  if (!planes.is(width, height, count)) planes = RowPlanes(width, height, count);
}

}  // namespace ld
