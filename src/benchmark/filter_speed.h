// The classical filters on frames in memory, pass by pass, beside what a perfect machine would take.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

#include "benchmark/size_times.h"

namespace ld {

/// Medians of one filter on frames of one size, 1 sample a pixel, in ms.
struct FilterTime {
  std::string name;  // svgf_2_1920x1080: the filter, its signals, the size
  double ms = 0;     // from the frame to the image, history there
  double guides_ms = 0, temporal_ms = 0, levels_ms = 0;  // what is left: recombination, antialiasing, image
  // Of the equations: floating-point operations, and planes that a pass reads or writes, each once.
  double operations = 0, bytes = 0;
};

/// EAW and SVGF with one and with two signals, at `width` x `height` and with twice as many rows, all in
/// turns.
std::vector<FilterTime> measure_filters(int width, int height, int repeats, int threads);

std::string markdown(const std::vector<FilterTime>& times, const MachineSpeed& machine);
nlohmann::ordered_json to_json(const std::vector<FilterTime>& times, const MachineSpeed& machine);

}  // namespace ld
