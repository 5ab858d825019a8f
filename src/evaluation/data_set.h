// The frames of one split of a data set on disk, for the evaluator.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "evaluation/evaluator.h"

namespace ld {

/// Adds to `features` what surface_guides() (sequence/surface_guides.h) reads, as far as the split's first
/// frame holds it. Throws Error as open_frame_set does.
void add_surface_features(const std::filesystem::path& folder, const std::string& split,
                          std::vector<std::string>& features);

/// The first `limit` frames of the split by their names, sequence by sequence (sequence/sequence_runs.h),
/// each with its first `samples` samples; 0: all. A gap in a sequence, which the limit may make, is the start
/// of another one. Each frame is checked against the manifest's checksums, read with at least `features`, and
/// its faults (and the reference's) are warned about once. Throws Error here for a missing folder or manifest
/// and for a split without frames; on loading, for a missing, changed or damaged file, a missing feature, too
/// few samples, and a reference of another size than the frame (naming both files and sizes).
FrameSet open_frame_set(const std::filesystem::path& folder, const std::string& split,
                        const std::vector<std::string>& features, size_t limit, int samples = 0);

}  // namespace ld
