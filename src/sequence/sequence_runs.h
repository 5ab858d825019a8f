// Which frames of a data set follow one another.
#pragma once

#include <cstddef>
#include <vector>

#include "frame/manifest.h"

namespace ld {

/// The frames by their numbers in the list, each once, in runs: frames of one sequence whose positions follow
/// one another without a gap, in that order. Frames of one position are noise instances: the first by name
/// makes a run with the first of the other positions, the second with the second. A frame without sequence or
/// position is a run of its own. Runs are ordered by their first frame.
std::vector<std::vector<size_t>> sequence_runs(const std::vector<ManifestFrame>& frames);

}  // namespace ld
