// The registry of metrics: the one list that tables, JSON and tests walk.
#pragma once

#include <string>
#include <vector>

#include "frame/frame.h"

namespace ld {

struct Metric {
  std::string name;   // in files and on command lines
  std::string title;  // heading of its column, for people
  bool lower_is_better;
  std::string domain;   // what it is computed on, epsilon included, for people
  std::string formula;  // of the denoised picture d and the reference r, constants included, for people
  int digits;           // decimals that a table shows
  double (*compute)(const Image& denoised,
                    const Image& reference);  // domain and errors: metrics/image_pair.h
};

/// All of them, in the order of the tables of [MH20] (Munkberg and Hasselgren 2020).
const std::vector<Metric>& metrics();

/// Throws UsageError with the nearest name and the list of names when there is no such metric.
const Metric& find_metric(const std::string& name);

/// Whether score `a` is strictly better than `b`. A NaN is worse than every number.
bool better(const Metric& metric, double a, double b);

}  // namespace ld
