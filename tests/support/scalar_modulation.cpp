#include "tests/support/scalar_modulation.h"

#include <algorithm>
#include <cmath>

namespace ld::reference {

Grid demodulator(const Grid& features, const NetworkLayout& layout) {
  Grid a(features.b, features.s, 3, features.h, features.w);
  each(a, [&](int64_t b, int64_t s, int64_t y, int64_t x) {
    bool none = true;
    for (int64_t c = 0; c < 3; ++c) {
      double& sum = a(b, s, c, y, x);
      sum = features(b, s, layout.albedo + c, y, x);
      if (layout.specular >= 0) sum += features(b, s, layout.specular + c, y, x);
      none = none && sum <= 1e-4;
    }
    for (int64_t c = 0; c < 3; ++c)
      a(b, s, c, y, x) = none ? 1 : std::min(std::max(a(b, s, c, y, x), 0.02), 64.0);
  });
  return a;
}

Grid both_forms(const Grid& radiance, const Grid& a) {
  Grid both(radiance.b, radiance.s, 6, radiance.h, radiance.w);
  each(both, [&](int64_t b, int64_t s, int64_t y, int64_t x) {
    for (int64_t c = 0; c < 3; ++c) {
      both(b, s, c, y, x) = radiance(b, s, c, y, x) / a(b, s, c, y, x);
      both(b, s, 3 + c, y, x) = radiance(b, s, c, y, x);
    }
  });
  return both;
}

Grid steadiness(const Grid& statistics) {
  Grid variance(statistics.b, 1, 1, statistics.h, statistics.w), out = variance;
  each(variance, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    for (int64_t c = 0; c < 3; ++c) {
      const double mean = statistics(b, 0, c, y, x);
      if (mean > 0) variance(b, 0, 0, y, x) += statistics(b, 0, 3 + c, y, x) / (mean * mean) / 3;
    }
  });
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    double sum = 0, count = 0;
    for (int64_t yy = std::max<int64_t>(y - 1, 0); yy < std::min(y + 2, out.h); ++yy)
      for (int64_t xx = std::max<int64_t>(x - 1, 0); xx < std::min(x + 2, out.w); ++xx, ++count)
        sum += variance(b, 0, 0, yy, xx);
    out(b, 0, 0, y, x) = std::exp(-12 * sum / count);
  });
  return out;
}

Grid modulated(const Grid& both, const Grid& statistics, const Grid& beta_logits) {
  Grid out(both.b, 1, 3, both.h, both.w);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    const bool drawn = statistics(b, 0, 0, y, x) > 0;
    const double beta = drawn ? 1 / (1 + std::exp(-beta_logits(b, 0, 0, y, x))) : 0;
    for (int64_t c = 0; c < 3; ++c)
      out(b, 0, c, y, x) =
          beta * statistics(b, 0, c, y, x) * both(b, 0, c, y, x) + (1 - beta) * both(b, 0, 3 + c, y, x);
  });
  return out;
}

}  // namespace ld::reference
