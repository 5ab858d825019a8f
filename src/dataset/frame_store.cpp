#include "dataset/frame_store.h"

#include <algorithm>

#include "core/error.h"
#include "frame/frame_file.h"
#include "frame/frame_pair.h"

namespace ld {

FrameStore::FrameStore(std::filesystem::path folder, const std::string& split,
                       std::vector<std::string> features, uint64_t budget_bytes)
    : folder_(std::move(folder)),
      features_(std::move(features)),
      budget_bytes_(budget_bytes),
      frames_(frames_of_split(folder_, split)),
      memory_(frames_.size()) {
  for (const ManifestFrame& frame : frames_) {
    const std::filesystem::path path = frame_path(folder_, frame.name);
    const FrameHeader header = read_frame_header(path);
    if (header.spp == 0)
      fail(
          "{} holds means only; a sample network needs sample parts s000, s001, ...: render with samples or "
          "train a "
          "pixel network",
          path.string());
    for (const std::string& feature : features_)
      if (std::find(header.features.begin(), header.features.end(), feature) == header.features.end())
        fail(
            "{} lacks the feature '{}' (channel {}) that network.features names; render it or remove it from "
            "the "
            "config",
            path.string(), feature, find_feature(feature).exr_channels[0]);
    sizes_.push_back({header.width, header.height});
  }
}

std::shared_ptr<const StoredFrame> FrameStore::get(size_t index) {
  if (memory_[index]) return memory_[index];
  FramePair pair = read_frame_pair(folder_, frames_[index], features_);
  warn_about_faults(folder_, frames_[index], pair);
  auto stored = std::make_shared<StoredFrame>();
  stored->frame = to_half(pair.frame);
  stored->reference = std::move(pair.reference);
  if (used_bytes_ + stored->bytes() <= budget_bytes_) {
    used_bytes_ += stored->bytes();
    memory_[index] = stored;
  }
  return stored;
}

}  // namespace ld
