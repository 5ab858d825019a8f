// Clips: what a training example is. One of length 1 is a frame.
#pragma once

#include <cstddef>
#include <vector>

#include "dataset/frame_store.h"

namespace ld {

/// Frames of a store by their numbers, in the order in which they follow one another.
using Clip = std::vector<size_t>;

/// All clips of so many frames, overlapping ones too, ordered by their first frame: of runs of one sequence
/// (sequence/sequence_runs.h), never across a gap or a change of size. Of length 1, every frame in the
/// store's order. Warns about frames that lie in no clip. Throws UsageError where there is no clip.
std::vector<Clip> clips_of(const FrameStore& store, int length);

/// How many clips an epoch takes so that it has each frame about once: the frames that lie in some clip,
/// divided by the length; at least 1.
size_t clips_per_epoch(const std::vector<Clip>& clips);

}  // namespace ld
