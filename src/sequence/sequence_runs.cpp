#include "sequence/sequence_runs.h"

#include <algorithm>
#include <map>
#include <utility>

namespace ld {

std::vector<std::vector<size_t>> sequence_runs(const std::vector<ManifestFrame>& frames) {
  std::vector<std::vector<size_t>> runs;
  std::map<std::pair<int64_t, int64_t>, std::vector<size_t>> places;  // sequence, position: its instances
  for (size_t i = 0; i < frames.size(); ++i)
    if (frames[i].sequence && frames[i].position)
      places[{*frames[i].sequence, *frames[i].position}].push_back(i);
    else
      runs.push_back({i});

  std::map<std::pair<int64_t, size_t>, std::vector<size_t>> open;  // sequence, instance: its last run
  for (auto& [place, instances] : places) {
    std::sort(instances.begin(), instances.end(),
              [&](size_t a, size_t b) { return frames[a].name < frames[b].name; });
    for (size_t instance = 0; instance < instances.size(); ++instance) {
      std::vector<size_t>& run = open[{place.first, instance}];
      if (!run.empty() && *frames[run.back()].position + 1 != place.second)
        runs.push_back(std::exchange(run, {}));
      run.push_back(instances[instance]);
    }
  }
  for (auto& [place, run] : open) runs.push_back(std::move(run));
  std::sort(runs.begin(), runs.end());
  return runs;
}

}  // namespace ld
