#include "metrics/metric.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "metrics/flip.h"
#include "metrics/psnr.h"
#include "metrics/relmse.h"
#include "metrics/smape.h"
#include "metrics/ssim.h"

namespace ld {
namespace {

constexpr const char* kDisplay = "tone-mapped radiance (log(1 + x), sRGB) clamped to [0, 1]";

const Metric& named(const std::vector<Metric>& all, const std::string& name) {
  std::vector<std::string> names;
  for (const Metric& metric : all) {
    if (metric.name == name) return metric;
    names.push_back(metric.name);
  }
  const std::string near = nearest_word(name, names);
  fail_usage("no metric '{}'{}; there are {}", name,
             near.empty() ? "" : fmt::format(", did you mean '{}'?", near), fmt::join(names, ", "));
}

}  // namespace

const std::vector<Metric>& metrics() {
  static const std::vector<Metric> all = {
      {"relmse", "relMSE", Best::lowest, fmt::format("linear radiance, epsilon {:g}", kRelmseEpsilon),
       relmse_formula(), 4, relmse},
      {"smape", "SMAPE", Best::lowest, fmt::format("linear radiance, epsilon {:g}", kSmapeEpsilon),
       smape_formula(), 4, smape},
      {"ssim", "SSIM", Best::highest,
       fmt::format("{}, {}x{} Gaussian window of sigma {:g}", kDisplay, kSsimWindow, kSsimWindow, kSsimSigma),
       ssim_formula(), 4, ssim},
      {"psnr", "PSNR", Best::highest, std::string(kDisplay) + ", dB", psnr_formula(), 2, psnr},
  };
  return all;
}

const std::vector<Metric>& further_metrics() {
  static const std::vector<Metric> all = {
      {"flip", "FLIP", Best::lowest, kDisplay, flip_formula(), 4, flip},
      {"hdr_flip", "HDR-FLIP", Best::lowest, "linear radiance", hdr_flip_formula(), 4, hdr_flip},
  };
  return all;
}

std::vector<const Metric*> metrics_with(const std::vector<std::string>& further) {
  std::vector<const Metric*> chosen;
  for (const Metric& metric : metrics()) chosen.push_back(&metric);
  for (const std::string& name : further) {
    const Metric* metric = &named(further_metrics(), name);
    if (std::find(chosen.begin(), chosen.end(), metric) == chosen.end()) chosen.push_back(metric);
  }
  return chosen;
}

const Metric& find_metric(const std::string& name) {
  return named(metrics(), name);
}

const char* better_word(Best best) {
  return best == Best::lowest ? "lower" : best == Best::highest ? "higher" : "nearer to 1";
}

bool better(const Metric& metric, double a, double b) {
  if (std::isnan(a)) return false;
  if (std::isnan(b)) return true;
  if (metric.best == Best::one) return std::abs(a - 1) < std::abs(b - 1);
  return metric.best == Best::lowest ? a < b : a > b;
}

}  // namespace ld
