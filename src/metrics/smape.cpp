#include "metrics/smape.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "metrics/image_pair.h"

namespace ld {

double smape(const Image& denoised, const Image& reference) {
  if (!comparable(denoised, reference)) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (size_t i = 0; i < reference.pixels.size(); ++i) {
    const double d = denoised.pixels[i];
    const double r = reference.pixels[i];
    sum += std::abs(d - r) / (std::abs(d) + std::abs(r) + kSmapeEpsilon);
  }
  return sum / static_cast<double>(reference.pixels.size());
}

std::string smape_formula() {
  return fmt::format("mean over pixels and channels of |d - r| / (|d| + |r| + {:g})", kSmapeEpsilon);
}

}  // namespace ld
