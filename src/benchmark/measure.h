// Times a piece of work against its baseline on a machine that does other things too.
#pragma once

#include <functional>
#include <vector>

#include "ops/composition.h"

namespace ld {

/// What is timed: the operators of the library, or, under ComposedOperators, their LibTorch composition.
struct Workload {
  std::function<void()> run;
  double multiply_adds = 0;                // of one run
  Taps baseline = Taps::at_once;           // how the composition is written (ops/composition.h)
  std::function<void()> composition = {};  // where it is other work than `run`
  double held_mb = 0;  // what `run` holds from call to call, on top of which its peak comes
};

struct MeasureOptions {
  int repeats = 7;               // of ours, at least; up to three times as many where one is fast
  double baseline_seconds = 30;  // about what the baseline may take in all; it runs at least once
};

struct Measurement {
  double ms = 0, baseline_ms = 0;  // medians
  double at_once_ms = 0;  // of the composition with Taps::at_once, where the baseline is the other one
  int repeats = 0, baseline_repeats = 0;
  double peak_mb = 0, baseline_peak_mb = 0;  // benchmark/peak_memory.h
};

/// Runs the work and its composition in turns, so that both see the same machine, after a warm-up of each.
/// Peak memory is that of one run more of ours, and of the baseline's warm-up.
Measurement measure_against_composition(const Workload& workload, const MeasureOptions& options);

/// The time of one run, in ms.
double time_ms(const std::function<void()>& work);

/// The middle value; the mean of the two middle ones of an even number. At least one value.
double median(std::vector<double> values);

/// The median of `repeats` runs after a warm-up, in ms.
double median_ms(const std::function<void()>& work, int repeats);

/// GB/s that all threads move in a = b + 3 c over arrays of 128 MB, as McCalpin's STREAM counts them (three
/// passes; what is read before it is written does not count): the median of `repeats`. `floats` of each array
/// for a quick test.
double memory_gb_per_s(int repeats, int64_t floats = int64_t(1) << 25);

/// GFLOP/s of a float32 matrix product of side `size`, two operations a multiply-add: the median of
/// `repeats`.
double sgemm_gflops(int64_t size, int repeats);

}  // namespace ld
