#include "benchmark/measure.h"

#include <gtest/gtest.h>
#include <torch/torch.h>

#include <chrono>
#include <string>
#include <thread>

#include "benchmark/peak_memory.h"
#include "ops/composition.h"
#include "tests/support/sanitized.h"

namespace ld {
namespace {

TEST(Measure, Medians) {
  EXPECT_EQ(median({3}), 3);
  EXPECT_EQ(median({5, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 9, 2}), 3);
}

TEST(Measure, TheBaselineRunsAsACompositionInTurnsWithOurs) {
  int ours = 0, composed = 0;
  std::string order;
  const auto work = [&] {
    const bool baseline = runs_composed(torch::zeros({1}));
    ++(baseline ? composed : ours);
    order += baseline ? 'b' : 'o';
    std::this_thread::sleep_for(std::chrono::milliseconds(baseline ? 40 : 2));
  };
  MeasureOptions options;
  options.repeats = 7;
  const Measurement m = measure_against_composition({work}, options);
  EXPECT_GE(m.repeats, 7);
  EXPECT_EQ(ours, m.repeats + 2);               // a warm-up and the run whose memory is measured
  EXPECT_EQ(composed, m.baseline_repeats + 1);  // a warm-up
  EXPECT_NE(order.find("obobob"), std::string::npos) << order;
  EXPECT_GE(m.ms, 2);
  EXPECT_GE(m.baseline_ms, 40);

  options.baseline_seconds = 0.06;  // for one run
  EXPECT_EQ(measure_against_composition({work}, options).baseline_repeats, 1);

  EXPECT_EQ(m.at_once_ms, 0);
  Workload other = {work};
  other.composition = [] { std::this_thread::sleep_for(std::chrono::milliseconds(20)); };
  other.held_mb = 1000;
  const int before = composed;
  const Measurement against_other = measure_against_composition(other, options);
  EXPECT_EQ(composed, before);  // the other work was the baseline
  EXPECT_GE(against_other.baseline_ms, 20);
  EXPECT_GE(against_other.peak_mb, 1000);
  EXPECT_GE(measure_against_composition({work, 0, Taps::sliced}, options).at_once_ms, 40);
}

TEST(Measure, PeakMemorySeesWhatWasFreedAgain) {
  if (kAddressSanitizer) GTEST_SKIP() << "the sanitizer's own memory would be measured";
  const double peak = peak_memory_mb([] { torch::ones({24'000'000}); });
  EXPECT_NEAR(peak, 96, 8);
  EXPECT_LT(peak_memory_mb([] {}), 8);
}

TEST(Measure, SgemmSpeedIsPositive) {
  EXPECT_GT(sgemm_gflops(64, 3), 0);
}

TEST(Measure, MemorySpeedIsPositive) {
  EXPECT_GT(memory_gb_per_s(3, 1 << 16), 0);
}

}  // namespace
}  // namespace ld
