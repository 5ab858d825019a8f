#include "evaluation/blur_sweep.h"

#include <cmath>

#include "core/threads.h"
#include "evaluation/gaussian_blur.h"
#include "metrics/image_pair.h"
#include "metrics/metric.h"

namespace ld {

const std::vector<double>& blur_sigmas() {
  static const std::vector<double> sigmas = [] {
    std::vector<double> steps;
    for (int i = -4; i <= 12; ++i) steps.push_back(std::exp2(i / 4.0));
    return steps;
  }();
  return sigmas;
}

void BlurSweep::add(const std::string& frame, const Image& noisy, const Image& reference, int threads) {
  std::vector<FrameScores> found(sweep_.size());
  parallel_for(static_cast<int64_t>(sweep_.size()), threads, [&](int64_t i) {
    const Image blurred = gaussian_blur(noisy, blur_sigmas()[size_t(i)]);
    FrameScores& scores = found[size_t(i)];
    scores.frame = frame;
    scores.not_finite = count_not_finite(blurred);
    for (const Metric& metric : metrics()) scores.values.push_back(metric.compute(blurred, reference));
  });
  for (size_t i = 0; i < sweep_.size(); ++i) sweep_[i].frames.push_back(std::move(found[i]));
}

size_t BlurSweep::best(size_t metric) const {
  size_t best = 0;
  for (size_t i = 1; i < sweep_.size(); ++i)
    if (better(metrics()[metric], sweep_[i].mean(metric), sweep_[best].mean(metric))) best = i;
  return best;
}

double BlurSweep::best_sigma(size_t metric) const {
  return blur_sigmas()[best(metric)];
}

MethodScores BlurSweep::scores() const {
  MethodScores result;
  result.name = "blur";
  result.frames = sweep_.front().frames;
  for (size_t m = 0; m < metrics().size(); ++m) {
    const size_t chosen = best(m);
    result.sigmas.push_back(blur_sigmas()[chosen]);
    for (size_t f = 0; f < result.frames.size(); ++f)
      result.frames[f].values[m] = sweep_[chosen].frames[f].values[m];
  }
  return result;
}

}  // namespace ld
