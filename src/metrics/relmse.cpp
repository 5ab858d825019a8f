#include "metrics/relmse.h"

#include <fmt/format.h>

#include <limits>

#include "metrics/image_pair.h"

namespace ld {

double relmse(const Image& denoised, const Image& reference) {
  if (!comparable(denoised, reference)) return std::numeric_limits<double>::quiet_NaN();
  double sum = 0;
  for (size_t i = 0; i < reference.pixels.size(); ++i) {
    const double r = reference.pixels[i];
    const double difference = denoised.pixels[i] - r;
    sum += difference * difference / (r * r + kRelmseEpsilon);
  }
  return sum / static_cast<double>(reference.pixels.size());
}

std::string relmse_formula() {
  return fmt::format("mean over pixels and channels of (d - r)^2 / (r^2 + {:g})", kRelmseEpsilon);
}

}  // namespace ld
