// The registry of metrics: the lists that tables, JSON and tests walk.
#pragma once

#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// Which score is the best one.
enum class Best { lowest, highest, one };

/// "lower", "higher" or "nearer to 1": what is better.
const char* better_word(Best best);

struct Metric {
  std::string name;   // in files and on command lines
  std::string title;  // heading of its column, for people
  Best best;
  std::string domain;   // what it is computed on, epsilon included, for people
  std::string formula;  // of the denoised picture d and the reference r, constants included, for people
  int digits;           // decimals that a table shows
  /// Domain and errors: metrics/image_pair.h. Null for measures of sequences (metrics/sequence_meter.h).
  double (*compute)(const Image& denoised, const Image& reference);
};

/// Those that every table has, in the order of [MH20] (Munkberg and Hasselgren 2020).
const std::vector<Metric>& metrics();

/// Those that take too long for every table: FLIP and HDR-FLIP.
const std::vector<Metric>& further_metrics();

/// metrics(), then those of the further ones that are named, each once. Throws UsageError for another name.
std::vector<const Metric*> metrics_with(const std::vector<std::string>& further);

/// One of metrics(). Throws UsageError with the nearest name and the list of names when there is none.
const Metric& find_metric(const std::string& name);

/// Whether score `a` is strictly better than `b`. A NaN is worse than every number.
bool better(const Metric& metric, double a, double b);

}  // namespace ld
