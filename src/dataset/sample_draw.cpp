#include "dataset/sample_draw.h"

#include <algorithm>
#include <numeric>

namespace ld {
namespace {

/// The parts of the range that lie in one octave each.
std::vector<SampleRange> octaves_of(const SampleRange& range) {
  std::vector<SampleRange> octaves;
  for (int low = 1; low <= range.most; low *= 2)
    if (2 * low > range.least)
      octaves.push_back({std::max(low, range.least), std::min(2 * low - 1, range.most)});
  return octaves;
}

}  // namespace

int draw_sample_count(RandomStream& stream, const SampleRange& range) {
  const std::vector<SampleRange> octaves = octaves_of(range);
  const SampleRange& octave = octaves[stream.below(static_cast<uint32_t>(octaves.size()))];
  return octave.least + static_cast<int>(stream.below(static_cast<uint32_t>(octave.most - octave.least + 1)));
}

double mean_sample_count(const SampleRange& range) {
  const std::vector<SampleRange> octaves = octaves_of(range);
  double sum = 0;
  for (const SampleRange& octave : octaves) sum += 0.5 * (octave.least + octave.most);
  return sum / static_cast<double>(octaves.size());
}

SampleList draw_samples(RandomStream& stream, int held, int count) {
  if (held <= count) return {};
  const std::vector<uint32_t> order = random_permutation(stream, static_cast<uint32_t>(held));
  SampleList samples(order.begin(), order.begin() + count);
  std::sort(samples.begin(), samples.end());
  return samples;
}

SampleList noisy_samples(Noisy noisy, int held, const SampleList& drawn) {
  if (noisy == Noisy::none) return {};
  SampleList all(static_cast<size_t>(held));
  std::iota(all.begin(), all.end(), 0);
  const SampleList& read = drawn.empty() ? all : drawn;
  if (noisy == Noisy::same) return read;
  SampleList others = other_samples(held, read);
  others.resize(std::min(others.size(), read.size()));
  return others;
}

SampleList other_samples(int held, const SampleList& samples) {
  SampleList others;
  for (int s = 0; s < held; ++s)
    if (!std::binary_search(samples.begin(), samples.end(), s)) others.push_back(s);
  return others;
}

}  // namespace ld
