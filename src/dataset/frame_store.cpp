#include "dataset/frame_store.h"

#include <algorithm>

#include "core/checksum.h"
#include "core/error.h"
#include "core/log.h"
#include "frame/frame_file.h"
#include "sequence/sequence_runs.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

/// Data sets that share a folder do not share their frames' names.
fs::path cache_folder(const fs::path& data_set, const std::string& folder) {
  if (folder.empty()) return data_set / ".cache";
  const std::string name = fs::weakly_canonical(data_set).string();
  return fs::path(folder) / checksum_text(name.data(), name.size());
}

void check_header(const fs::path& path, const FrameHeader& header, const std::vector<std::string>& features) {
  if (header.spp == 0)
    fail("{} holds means only; expected sample parts s000, s001, ...: render with samples", path.string());
  for (const std::string& feature : features)
    if (std::find(header.features.begin(), header.features.end(), feature) == header.features.end() &&
        std::find(header.derivable.begin(), header.derivable.end(), feature) == header.derivable.end())
      fail(
          "{} lacks the feature '{}' (channel {}) that network.features names; render it, remove it from the "
          "config or say network.features=auto",
          path.string(), feature, find_feature(feature).exr_channels[0]);
}

}  // namespace

FrameStore::FrameStore(fs::path data_set, const std::string& split, std::vector<std::string> features,
                       const CacheOptions& options)
    : FrameStore(data_set, frames_of_split(data_set, split), std::move(features), options) {}

FrameStore::FrameStore(fs::path data_set, std::vector<ManifestFrame> frames,
                       std::vector<std::string> features, const CacheOptions& options)
    : data_set_(std::move(data_set)), features_(std::move(features)), memory_budget_(options.memory) {
  for (ManifestFrame& frame : frames) {
    const fs::path path = frame_path(data_set_, frame.name);
    const FrameHeader header = read_frame_header(path);
    check_header(path, header, features_);
    auto entry = std::make_unique<Entry>();
    entry->frame = std::move(frame);
    entry->width = header.width;
    entry->height = header.height;
    entry->spp = header.spp;
    entries_.push_back(std::move(entry));
  }
  if (options.folder != "none")
    cache_ =
        std::make_unique<FrameCache>(cache_folder(data_set_, options.folder), features_, options.reserve);
}

std::vector<size_t> FrameStore::instances(size_t index) const {
  const ManifestFrame& frame = entries_[index]->frame;
  if (!frame.sequence || !frame.position) return {index};
  std::vector<size_t> found;
  for (size_t i = 0; i < entries_.size(); ++i)
    if (entries_[i]->frame.sequence == frame.sequence && entries_[i]->frame.position == frame.position)
      found.push_back(i);
  return found;
}

std::vector<std::vector<size_t>> FrameStore::runs() const {
  std::vector<ManifestFrame> frames;
  for (const auto& entry : entries_) frames.push_back(entry->frame);
  return sequence_runs(frames);
}

std::shared_ptr<const PackedFrame> FrameStore::get(size_t index) {
  Entry& entry = *entries_[index];
  const std::lock_guard<std::mutex> lock(entry.mutex);
  return entry.memory ? entry.memory : read(entry);
}

std::shared_ptr<const PackedFrame> FrameStore::get_intact(size_t index,
                                                          const std::shared_ptr<const PackedFrame>& frame,
                                                          const TileRange& range, const SampleList& samples) {
  if (!cache_) return frame;
  read_ahead(*frame, range, samples);
  if (frame->intact(range, samples)) return frame;
  Entry& entry = *entries_[index];
  const std::lock_guard<std::mutex> lock(entry.mutex);
  // Another thread may have made it again meanwhile.
  if (auto again = read(entry); again->intact(range, samples)) return again;
  const fs::path path = cache_->path(entry.frame.name);
  spdlog::warn("damaged cache file, made again: {}: samples do not match their checksum", path.string());
  fs::remove(path);
  return read(entry);
}

std::shared_ptr<const PackedFrame> FrameStore::read(Entry& entry) {
  std::string source;
  if (cache_) {
    source = source_state(data_set_, entry.frame);  // before the pixels: a change while they are read counts
    if (auto cached = cache_->open(entry.frame.name, source))
      return std::make_shared<const PackedFrame>(std::move(*cached));
  }
  const FramePair pair = read_frame_pair(data_set_, entry.frame, features_);
  warn_about_faults(data_set_, entry.frame, pair);
  const auto packed = std::make_shared<const PackedFrame>(pack(pair, features_));
  if (cache_ && cache_->write(entry.frame.name, source, *packed)) return packed;
  if (memory_used_ + packed->bytes() <= memory_budget_) {
    memory_used_ += packed->bytes();
    entry.memory = packed;
  }
  return packed;
}

}  // namespace ld
