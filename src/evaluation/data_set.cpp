#include "evaluation/data_set.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "frame/frame_pair.h"

namespace ld {

FrameSet open_frame_set(const std::filesystem::path& folder, const std::string& split,
                        const std::vector<std::string>& features, size_t limit, int samples) {
  std::vector<ManifestFrame> frames = frames_of_split(folder, split);
  if (limit > 0 && frames.size() > limit) frames.resize(limit);

  const size_t count = frames.size();
  std::vector<std::string> names;
  for (const ManifestFrame& frame : frames) names.push_back(frame.name);
  const auto warned = std::make_shared<std::vector<bool>>(count, false);
  const auto load = [folder, features, samples, warned, frames = std::move(frames)](size_t i) {
    FramePair pair = read_frame_pair(folder, frames[i], features, samples);
    if (!(*warned)[i]) warn_about_faults(folder, frames[i], pair);
    (*warned)[i] = true;
    return EvaluationFrame{frames[i].name, std::move(pair.frame), std::move(pair.reference.image),
                           std::move(pair.reference.floor), pair.place};
  };
  return {count, load, std::move(names)};
}

}  // namespace ld
