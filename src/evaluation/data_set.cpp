#include "evaluation/data_set.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "frame/frame_file.h"
#include "frame/frame_pair.h"
#include "sequence/sequence_runs.h"

namespace ld {

void add_surface_features(const std::filesystem::path& folder, const std::string& split,
                          std::vector<std::string>& features) {
  const FrameHeader header =
      read_frame_header(frame_path(folder, frames_of_split(folder, split).front().name));
  for (const char* name : {"depth", "normal", "flow", "id", "flow_depth"})
    if (std::count(header.features.begin(), header.features.end(), name) > 0 &&
        std::count(features.begin(), features.end(), name) == 0)
      features.emplace_back(name);
}

FrameSet open_frame_set(const std::filesystem::path& folder, const std::string& split,
                        const std::vector<std::string>& features, size_t limit, int samples) {
  std::vector<ManifestFrame> by_name = frames_of_split(folder, split), frames;
  if (limit > 0 && by_name.size() > limit) by_name.resize(limit);
  const size_t count = by_name.size();
  std::vector<std::string> names;
  std::vector<SequencePlace> places;
  std::vector<std::vector<size_t>> sequences;
  int64_t number = 0;
  for (const std::vector<size_t>& run : sequence_runs(by_name)) {
    if (run.size() > 1) sequences.emplace_back();
    for (const size_t i : run) {
      if (run.size() > 1) sequences.back().push_back(frames.size());
      places.push_back({number, static_cast<int64_t>(frames.size())});
      names.push_back(by_name[i].name);
      frames.push_back(std::move(by_name[i]));
    }
    ++number;
  }
  const auto warned = std::make_shared<std::vector<bool>>(count, false);
  const auto load = [folder, features, samples, warned, places, frames = std::move(frames)](size_t i) {
    FramePair pair = read_frame_pair(folder, frames[i], features, samples);
    if (!(*warned)[i]) warn_about_faults(folder, frames[i], pair);
    (*warned)[i] = true;
    return EvaluationFrame{frames[i].name,
                           std::move(pair.frame),
                           std::move(pair.reference.image),
                           std::move(pair.reference.floor),
                           pair.place,
                           places[i]};
  };
  return {count, load, std::move(names), std::move(sequences)};
}

}  // namespace ld
