// Plain arrays for the scalar references: what tests compare tensors with.
#pragma once

#include <cstdint>
#include <vector>

namespace ld::reference {

/// [B, S, C, H, W] numbers in double; S is samples, layers or 1.
struct Grid {
  int64_t b = 0, s = 0, c = 0, h = 0, w = 0;
  std::vector<double> values;

  Grid() = default;
  Grid(int64_t b_, int64_t s_, int64_t c_, int64_t h_, int64_t w_)
      : b(b_), s(s_), c(c_), h(h_), w(w_), values(static_cast<size_t>(b_ * s_ * c_ * h_ * w_)) {}

  double& operator()(int64_t ib, int64_t is, int64_t ic, int64_t y, int64_t x) {
    return values[static_cast<size_t>((((ib * s + is) * c + ic) * h + y) * w + x)];
  }
  double operator()(int64_t ib, int64_t is, int64_t ic, int64_t y, int64_t x) const {
    return const_cast<Grid*>(this)->operator()(ib, is, ic, y, x);
  }
};

}  // namespace ld::reference
