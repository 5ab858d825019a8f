#include "metrics/metric.h"

#include <cmath>

#include "core/error.h"
#include "metrics/psnr.h"
#include "metrics/relmse.h"
#include "metrics/smape.h"
#include "metrics/ssim.h"

namespace ld {

const std::vector<Metric>& metrics() {
  static const std::string display = "tone-mapped radiance (log(1 + x), sRGB) clamped to [0, 1]";
  static const std::vector<Metric> all = {
      {"relmse", "relMSE", true, fmt::format("linear radiance, epsilon {:g}", kRelmseEpsilon),
       relmse_formula(), 4, relmse},
      {"smape", "SMAPE", true, fmt::format("linear radiance, epsilon {:g}", kSmapeEpsilon), smape_formula(),
       4, smape},
      {"ssim", "SSIM", false,
       fmt::format("{}, {}x{} Gaussian window of sigma {:g}", display, kSsimWindow, kSsimWindow, kSsimSigma),
       ssim_formula(), 4, ssim},
      {"psnr", "PSNR", false, display + ", dB", psnr_formula(), 2, psnr},
  };
  return all;
}

const Metric& find_metric(const std::string& name) {
  std::vector<std::string> names;
  for (const Metric& metric : metrics()) {
    if (metric.name == name) return metric;
    names.push_back(metric.name);
  }
  const std::string near = nearest_word(name, names);
  fail_usage("no metric '{}'{}; there are {}", name,
             near.empty() ? "" : fmt::format(", did you mean '{}'?", near), fmt::join(names, ", "));
}

bool better(const Metric& metric, double a, double b) {
  if (std::isnan(a)) return false;
  if (std::isnan(b)) return true;
  return metric.lower_is_better ? a < b : a > b;
}

}  // namespace ld
