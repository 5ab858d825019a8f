// The frames and references of one split of a data set: from its cache files, which are made when a frame is
// first needed, or, where none can be written, from the EXRs and memory.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "dataset/frame_cache.h"
#include "dataset/packed_frame.h"
#include "frame/manifest.h"

namespace ld {

struct CacheOptions {
  /// Folder of the cache files; "": .cache in the data set's folder; "none": no files.
  std::string folder;
  /// Memory for frames that are not in a cache file; those beyond it are read again each time.
  uint64_t memory = 0;
  uint64_t reserve = FrameCache::kReserve;
};

class FrameStore {
 public:
  /// Reads all headers, so that what does not fit is an error now rather than hours later. Throws Error: no
  /// frames in the split, a missing file or feature.
  FrameStore(std::filesystem::path data_set, const std::string& split, std::vector<std::string> features,
             const CacheOptions& options);
  /// The same for these frames of the folder.
  FrameStore(std::filesystem::path data_set, std::vector<ManifestFrame> frames,
             std::vector<std::string> features, const CacheOptions& options);

  const std::filesystem::path& folder() const { return data_set_; }
  size_t size() const { return entries_.size(); }
  /// The numbers of the frames, in runs of those that follow one another (sequence/sequence_runs.h).
  std::vector<std::vector<size_t>> runs() const;
  /// The frames of its sequence and position, itself among them: noise instances.
  std::vector<size_t> instances(size_t index) const;
  const std::string& name(size_t index) const { return entries_[index]->frame.name; }
  int width(size_t index) const { return entries_[index]->width; }
  int height(size_t index) const { return entries_[index]->height; }
  int spp(size_t index) const { return entries_[index]->spp; }

  /// The frame, from its cache file or memory, else from its EXRs (then verified against their checksums and
  /// faults logged). Safe to call from several threads. Throws Error: a file that is missing, damaged or not
  /// what its checksum says, a reference of another size.
  std::shared_ptr<const PackedFrame> get(size_t index);

  /// get() with the samples of the tiles checked that a crop will read: where the cache file is damaged
  /// there, it is made again. Other samples are not read.
  std::shared_ptr<const PackedFrame> get_intact(size_t index, const std::shared_ptr<const PackedFrame>& frame,
                                                const TileRange& range, const SampleList& samples = {});

 private:
  struct Entry {
    ManifestFrame frame;
    int width = 0, height = 0, spp = 0;
    std::mutex mutex;  // of what follows, and of the cache file
    std::shared_ptr<const PackedFrame> memory;
  };

  std::shared_ptr<const PackedFrame> read(Entry& entry);

  std::filesystem::path data_set_;
  std::vector<std::string> features_;
  std::unique_ptr<FrameCache> cache_;  // none: no files
  uint64_t memory_budget_;
  std::atomic<uint64_t> memory_used_{0};
  std::vector<std::unique_ptr<Entry>> entries_;
};

}  // namespace ld
