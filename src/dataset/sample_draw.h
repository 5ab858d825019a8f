// How many samples a training batch uses, and which of a frame's: the samples of a pixel are interchangeable,
// so a frame that holds more of them than a network sees is another input each time.
#pragma once

#include "core/random.h"
#include "dataset/packed_frame.h"

namespace ld {

/// From `least` to `most` samples a pixel, both included; 0 and 0: all samples of each frame.
struct SampleRange {
  int least = 0, most = 0;
  bool all() const { return most == 0; }
};

/// A number of the range. First an octave, 2^k to 2^(k+1) - 1, each that the range touches equally likely;
/// then a number of the octave that the range holds, each equally likely: of [1, 8], 1 and 8 a quarter of the
/// time each, 2 and 3 an eighth, 4 to 7 a sixteenth. Noise falls by a factor an octave, not by a sample.
int draw_sample_count(RandomStream& stream, const SampleRange& range);

/// What draw_sample_count() gives on average.
double mean_sample_count(const SampleRange& range);

/// `count` of the samples 0 ... held - 1 without replacement, each set of them equally likely; all where
/// there are no more than `count`.
SampleList draw_samples(RandomStream& stream, int held, int count);

/// Noisy pictures beside those that a network reads, for what learns from noise: none; of the frame's other
/// samples, as many as are read; or of the same samples, whose light is then not read.
enum class Noisy { none, others, same };

/// Which samples those are, where a network reads the samples `drawn`, all of them where that is empty; there
/// may be none left.
SampleList noisy_samples(Noisy noisy, int held, const SampleList& drawn);

/// The samples 0 ... held - 1 that are not in the ascending list.
SampleList other_samples(int held, const SampleList& samples);

}  // namespace ld
