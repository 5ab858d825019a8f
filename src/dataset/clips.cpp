#include "dataset/clips.h"

#include <algorithm>
#include <set>

#include "core/error.h"
#include "core/log.h"

namespace ld {
namespace {

size_t frames_in(const std::vector<Clip>& clips) {
  std::set<size_t> frames;
  for (const Clip& clip : clips) frames.insert(clip.begin(), clip.end());
  return frames.size();
}

/// The runs of the store's frames, cut where their size changes.
std::vector<Clip> runs_of_one_size(const FrameStore& store) {
  std::vector<Clip> runs;
  for (const std::vector<size_t>& run : store.runs())
    for (size_t i = 0; i < run.size(); ++i) {
      if (i == 0 || store.width(run[i]) != store.width(run[i - 1]) ||
          store.height(run[i]) != store.height(run[i - 1]))
        runs.emplace_back();
      runs.back().push_back(run[i]);
    }
  return runs;
}

}  // namespace

std::vector<Clip> clips_of(const FrameStore& store, int length) {
  std::vector<Clip> clips;
  std::ptrdiff_t longest = 0;
  for (const Clip& run : runs_of_one_size(store)) {
    longest = std::max(longest, std::ptrdiff_t(run.size()));
    for (auto first = run.begin(); run.end() - first >= length; ++first)
      clips.emplace_back(first, first + length);
  }
  if (clips.empty())
    fail_usage(
        "data.clip: no {} frames of {} follow one another, at most {} do; render sequences (sequence.length "
        "in a recipe) or set data.clip={} or less",
        length, store.folder().string(), longest, longest);
  if (const size_t held = frames_in(clips); held < store.size())
    spdlog::warn("data.clip={}: {} of {} frames of {} are left out, because fewer follow one another", length,
                 store.size() - held, store.size(), store.folder().string());
  std::sort(clips.begin(), clips.end());
  return clips;
}

size_t clips_per_epoch(const std::vector<Clip>& clips) {
  return frames_in(clips) / clips.front().size();
}

}  // namespace ld
