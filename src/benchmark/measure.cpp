#include "benchmark/measure.h"

#include <ATen/Parallel.h>
#include <torch/torch.h>

#include <algorithm>
#include <chrono>
#include <vector>

#include "benchmark/peak_memory.h"
#include "ops/composition.h"

namespace ld {

double time_ms(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const size_t middle = values.size() / 2;
  return values.size() % 2 == 1 ? values[middle] : 0.5 * (values[middle - 1] + values[middle]);
}

Measurement measure_against_composition(const Workload& workload, const MeasureOptions& options) {
  const std::function<void()>& work = workload.run;
  const auto composed = [&] {
    const ComposedOperators scope(workload.baseline);
    (workload.composition ? workload.composition : work)();
  };
  Measurement result;
  double first_ms = 0;
  result.baseline_peak_mb = peak_memory_mb([&] { first_ms = time_ms(composed); });
  work();
  double ours_ms = 0;
  result.peak_mb = workload.held_mb + peak_memory_mb([&] { ours_ms = time_ms(work); });

  // A row of milliseconds is repeated more often: up to three times, for about a second.
  result.repeats = int(std::clamp(1e3 / ours_ms, double(options.repeats), 3.0 * options.repeats));
  result.baseline_repeats =
      int(std::clamp(1e3 * options.baseline_seconds / first_ms, 1.0, double(result.repeats)));
  std::vector<double> ours, theirs;
  for (int i = 0; i < result.repeats; ++i) {
    ours.push_back(time_ms(work));
    // A baseline with fewer runs has them spread over the others'.
    if ((i + 1) * result.baseline_repeats / result.repeats > int(theirs.size()))
      theirs.push_back(time_ms(composed));
  }
  result.ms = median(ours);
  result.baseline_ms = median(theirs);
  if (workload.baseline == Taps::sliced) {
    const ComposedOperators scope;
    result.at_once_ms = median_ms(work, 3);
  }
  return result;
}

double median_ms(const std::function<void()>& work, int repeats) {
  work();
  std::vector<double> times;
  for (int i = 0; i < repeats; ++i) times.push_back(time_ms(work));
  return median(times);
}

double memory_gb_per_s(int repeats, int64_t floats) {
  const auto count = size_t(floats);
  std::vector<float> a(count), b(count, 1), c(count, 2);
  const double ms = median_ms(
      [&] {
        at::parallel_for(0, floats, 1 << 14, [&](int64_t begin, int64_t end) {
          for (int64_t i = begin; i < end; ++i) a[size_t(i)] = b[size_t(i)] + 3 * c[size_t(i)];
        });
      },
      repeats);
  return 3e-6 * sizeof(float) * double(floats) / ms;
}

double sgemm_gflops(int64_t size, int repeats) {
  const torch::Tensor a = torch::ones({size, size}), b = torch::ones({size, size});
  torch::Tensor c = torch::empty({size, size});
  const double ms = median_ms([&] { torch::mm_out(c, a, b); }, repeats);
  return 2e-6 * double(size) * double(size) * double(size) / ms;
}

}  // namespace ld
