// Work on pictures in strips of rows, so that what is needed for a moment never exists for the whole picture.
#pragma once

#include <torch/torch.h>

#include <algorithm>
#include <vector>

namespace ld {

/// Rows [begin, end) of a tensor whose last two axes are H and W.
inline torch::Tensor rows(const torch::Tensor& t, int64_t begin, int64_t end) {
  return t.defined() ? t.narrow(t.dim() - 2, begin, end - begin) : t;
}

/// While one lives, strips of this thread take about `bytes` instead of 256 MB: for tests on small pictures.
class StripBytes {
 public:
  explicit StripBytes(int64_t bytes) : before_(current()) { current() = bytes; }
  ~StripBytes() { current() = before_; }
  StripBytes(const StripBytes&) = delete;
  StripBytes& operator=(const StripBytes&) = delete;
  static int64_t& current() {
    static thread_local int64_t bytes = int64_t(256) << 20;
    return bytes;
  }

 private:
  int64_t before_;
};

/// How many of `height` rows to take at a time (an even number, or all) when each needs `bytes_per_row`
/// besides what it leaves behind, and strips must overlap. All of them where a gradient is kept: the graph
/// holds everything anyway.
inline int64_t strip_rows(int64_t height, int64_t bytes_per_row, int64_t parts = 1) {
  if (at::GradMode::is_enabled()) return height;
  const int64_t fitting = StripBytes::current() / parts / std::max<int64_t>(bytes_per_row, 1) / 2 * 2;
  return std::min(height, std::max<int64_t>(fitting, 16));
}

/// The same for work that needs no overlap: smaller strips, two to three times as fast because they stay in
/// the cache (16 MB, measured from 1 to 256).
inline int64_t short_strip_rows(int64_t height, int64_t bytes_per_row) {
  return strip_rows(height, bytes_per_row, 16);
}

/// The tensors that body(begin, end) returns for strips of `step` rows, put together along their rows.
template <class Body>
std::vector<torch::Tensor> in_strips(int64_t height, int64_t step, const Body& body) {
  if (step >= height) return body(int64_t(0), height);
  std::vector<torch::Tensor> whole;
  for (int64_t begin = 0; begin < height; begin += step) {
    const int64_t end = std::min(begin + step, height);
    const std::vector<torch::Tensor> strip = body(begin, end);
    for (size_t i = 0; i < strip.size(); ++i) {
      if (begin == 0) {
        std::vector<int64_t> sizes = strip[i].sizes().vec();
        sizes[sizes.size() - 2] = height;
        const bool picture = sizes.size() == 4;  // may have its channels last
        whole.push_back(at::empty(sizes, strip[i].options(),
                                  picture ? strip[i].suggest_memory_format() : at::MemoryFormat::Contiguous));
      }
      rows(whole[i], begin, end).copy_(strip[i]);
    }
  }
  return whole;
}

}  // namespace ld
