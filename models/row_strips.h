// Work on pictures in strips of rows, so that what is needed for a moment never exists for the whole picture.
#pragma once

#include <torch/torch.h>

#include <algorithm>
#include <functional>
#include <vector>

#include "core/scoped_value.h"

namespace ld {

/// Rows [begin, end) of a tensor whose last two axes are H and W.
inline torch::Tensor rows(const torch::Tensor& t, int64_t begin, int64_t end) {
  return t.defined() ? t.narrow(t.dim() - 2, begin, end - begin) : t;
}

/// What a strip takes; more makes nothing faster.
constexpr int64_t kStripBytes = int64_t(256) << 20;

/// While one lives, strips of this thread take about `bytes` instead.
class StripBytes : public ScopedValue<StripBytes, int64_t> {
 public:
  using ScopedValue::ScopedValue;
  static int64_t outside() { return kStripBytes; }
};

/// A strip has at least so many rows, whatever they take.
constexpr int64_t kFewestStripRows = 16;

/// How many of `height` rows to take at a time (a multiple of 8, or all) when each needs `bytes_per_row`
/// besides what it leaves behind, and a strip reads `reach` rows more. All of them where a gradient is kept:
/// the graph holds everything anyway.
inline int64_t strip_rows(int64_t height, int64_t bytes_per_row, int64_t reach = 0, int64_t parts = 1) {
  if (at::GradMode::is_enabled()) return height;
  const int64_t fitting = StripBytes::current() / parts / std::max<int64_t>(bytes_per_row, 1) - reach;
  return std::min(height, std::max(fitting / 8 * 8, kFewestStripRows));
}

/// The same for work that needs no overlap: smaller strips, two to three times as fast because they stay in
/// the cache (16 MB, measured from 1 to 256).
inline int64_t short_strip_rows(int64_t height, int64_t bytes_per_row) {
  return strip_rows(height, bytes_per_row, 0, 16);
}

/// Whether a picture that strips can make anew is worth the memory of keeping it.
inline bool keeps_rows(int64_t bytes) {
  return at::GradMode::is_enabled() || bytes <= 2 * StripBytes::current();
}

/// make(begin, end) itself, or what it makes of all rows, kept.
inline std::function<torch::Tensor(int64_t, int64_t)> kept_rows(
    const std::function<torch::Tensor(int64_t, int64_t)>& make, int64_t height, int64_t bytes) {
  if (!keeps_rows(bytes)) return make;
  return [whole = make(0, height)](int64_t begin, int64_t end) { return rows(whole, begin, end); };
}

/// Called with the share of the work that is done (0 to 1) after each strip, in the thread that the network
/// runs in; may throw to end it. While one lives.
class StripProgress : public ScopedValue<StripProgress, std::function<void(double)>> {
 public:
  using ScopedValue::ScopedValue;
};

inline void strips_done(double share) {
  if (StripProgress::current()) StripProgress::current()(share);
}

/// What strips make and hand on is a tensor, or a struct of tensors with a tensors_of() of its own. A tensor
/// that the network has no use for is undefined.
inline std::vector<torch::Tensor*> tensors_of(torch::Tensor& t) {
  return {&t};
}

/// rows() of all tensors of a struct.
template <class Strip>
Strip rows_of(Strip strip, int64_t begin, int64_t end) {
  for (torch::Tensor* t : tensors_of(strip)) *t = rows(*t, begin, end);
  return strip;
}

/// Strips put together, first row first. Each tensor's strips are free before the next one is put together.
template <class Strip>
Strip stacked_rows(std::vector<Strip> strips) {
  if (strips.size() == 1) return std::move(strips[0]);
  Strip whole;
  const std::vector<torch::Tensor*> to = tensors_of(whole);
  for (size_t i = 0; i < to.size(); ++i) {
    std::vector<torch::Tensor> parts;
    for (Strip& strip : strips) parts.push_back(std::move(*tensors_of(strip)[i]));
    if (parts[0].defined()) *to[i] = at::cat(parts, parts[0].dim() - 2);
  }
  return whole;
}

/// Room for a tensor of which `strip` holds some of `height` rows.
inline torch::Tensor room_for(const torch::Tensor& strip, int64_t height) {
  std::vector<int64_t> sizes = strip.sizes().vec();
  // Checked, as GCC 14 warns that there might be one size only.
  sizes.at(sizes.size() - 2) = height;
  const bool picture = sizes.size() == 4;  // may have its channels last
  return at::empty(sizes, strip.options(),
                   picture ? strip.suggest_memory_format() : at::MemoryFormat::Contiguous);
}

/// What body(begin, end) returns for strips of `step` rows of [first, last), put together, first row first.
template <class Body>
auto in_strips(int64_t first, int64_t last, int64_t step, const Body& body) {
  if (step >= last - first) return body(first, last);
  decltype(body(first, last)) whole;
  const std::vector<torch::Tensor*> to = tensors_of(whole);
  for (int64_t begin = first; begin < last; begin += step) {
    const int64_t end = std::min(begin + step, last);
    auto strip = body(begin, end);
    const std::vector<torch::Tensor*> from = tensors_of(strip);
    for (size_t i = 0; i < from.size(); ++i) {
      if (!from[i]->defined()) continue;
      if (begin == first) *to[i] = room_for(*from[i], last - first);
      rows(*to[i], begin - first, end - first).copy_(*from[i]);
    }
  }
  return whole;
}
template <class Body>
auto in_strips(int64_t height, int64_t step, const Body& body) {
  return in_strips(0, height, step, body);
}

/// Strips whose work reaches `reach` rows beyond them. make(begin, end) makes what it reads, each row once:
/// what two strips share is kept from one to the next. use(made, first, begin, end) returns the result of
/// rows [begin, end); row 0 of `made` is row `first` of the picture.
template <class Make, class Use>
auto in_reaching_strips(int64_t height, int64_t step, int64_t reach, const Make& make, const Use& use) {
  decltype(make(0, height)) made;
  const std::vector<torch::Tensor*> kept = tensors_of(made);
  int64_t made_first = 0, made_last = 0;
  return in_strips(height, step, [&](int64_t begin, int64_t end) {
    const int64_t first = std::max<int64_t>(begin - reach, 0), last = std::min(end + reach, height);
    for (torch::Tensor* t : kept)
      if (t->defined()) *t = rows(*t, first - made_first, made_last - made_first).clone();
    if (made_last < last) {
      auto next = make(made_last, last);
      const std::vector<torch::Tensor*> further = tensors_of(next);
      for (size_t i = 0; i < kept.size(); ++i) {
        if (kept[i]->defined()) *further[i] = at::cat({*kept[i], *further[i]}, kept[i]->dim() - 2);
        *kept[i] = std::move(*further[i]);
      }
    }
    made_first = first;
    made_last = last;
    auto result = use(made, first, begin, end);
    strips_done(0.5 + 0.5 * double(end) / double(height));
    return result;
  });
}

}  // namespace ld
