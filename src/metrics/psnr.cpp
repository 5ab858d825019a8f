#include "metrics/psnr.h"

#include <cmath>
#include <limits>

#include "metrics/image_pair.h"

namespace ld {

double psnr(const Image& denoised, const Image& reference) {
  if (!comparable(denoised, reference)) return std::numeric_limits<double>::quiet_NaN();
  const std::vector<double> d = display_values(denoised);
  const std::vector<double> r = display_values(reference);
  double sum = 0;
  for (size_t i = 0; i < r.size(); ++i) sum += (d[i] - r[i]) * (d[i] - r[i]);
  // Stated apart, because -10 log10(0) is a division by zero to the sanitizers.
  if (sum <= 0) return std::numeric_limits<double>::infinity();
  return -10 * std::log10(sum / static_cast<double>(r.size()));
}

std::string psnr_formula() {
  return "-10 log10(mean over pixels and channels of (T(d) - T(r))^2), T(x) = min(sRGB(log(1 + max(x, 0))), "
         "1)";
}

}  // namespace ld
