// Networks in the runtime on frames of several sizes, beside what a perfect machine would take.
#pragma once

#include <nlohmann/json.hpp>

#include <functional>
#include <string>
#include <vector>

#include "benchmark/planned_network.h"

namespace ld {

/// What this machine reaches (benchmark/measure.h).
struct MachineSpeed {
  double sgemm_gflops = 0, memory_gb_per_s = 0;
};

/// A network on frames of one size, which has not been set up yet.
struct SizeRow {
  std::string name;  // layer_1920x1080
  std::function<NetworkWeights()> network;
  PictureExtent picture;
};

/// The networks of all configurations and the released weights, on frames of all sizes.
std::vector<SizeRow> size_rows(const BenchSizes& sizes);

struct SizeTime {
  std::string name;
  double ms = 0;  // median
  int repeats = 0;
  double multiply_adds = 0, bytes = 0;  // PlannedNetwork

  /// Of the products at the speed of sgemm; of the bytes at that of memory.
  double arithmetic_ms(const MachineSpeed& machine) const;
  double memory_ms(const MachineSpeed& machine) const;
  /// Of a machine that does both at once and never waits.
  double perfect_ms(const MachineSpeed& machine) const;
};

/// The median of `repeats` runs after a warm-up; of as many as 10 s hold, one at least, where those are
/// fewer.
SizeTime time_size(const SizeRow& row, int repeats);

std::string markdown(const std::vector<SizeTime>& times, const MachineSpeed& machine);
nlohmann::ordered_json to_json(const std::vector<SizeTime>& times, const MachineSpeed& machine);

}  // namespace ld
