// Cache files: packed frames as safetensors, memory-mapped, one a frame (docs/loading.md describes them).
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "dataset/packed_frame.h"
#include "frame/manifest.h"

namespace ld {

/// Sizes, times of change and checksums of a frame's two files as the disk and the manifest have them: when
/// this text changes, the frame has changed. Throws Error when a file is missing.
std::string source_state(const std::filesystem::path& data_set, const ManifestFrame& frame);

/// The cache files of one data set and one set of features. Safe to use from several threads and processes.
class FrameCache {
 public:
  /// Space that is left free on the disk for checkpoints and others.
  static constexpr uint64_t kReserve = uint64_t{1} << 30;

  /// Files go below FOLDER/KEY, where KEY stands for the features and the version of the format, so that
  /// trainings with different features share a folder.
  FrameCache(const std::filesystem::path& folder, const std::vector<std::string>& features,
             uint64_t reserve = kReserve);

  std::filesystem::path path(const std::string& name) const;

  /// The frame, mapped: nothing but the index is read. Nothing when there is no file of that source, or a
  /// damaged one, which is reported. Whether tiles are damaged is for PackedFrame::intact() to say.
  std::optional<PackedFrame> open(const std::string& name, const std::string& source) const;

  /// Beside, flushed, renamed. False where that fails or the disk is almost full: one warning, and nothing is
  /// written from then on.
  bool write(const std::string& name, const std::string& source, const PackedFrame& frame);

 private:
  std::filesystem::path folder_;
  std::vector<std::string> features_;
  uint64_t reserve_;
  std::atomic<bool> writable_{true};
};

/// Starts reading these samples of the tiles of a mapped frame from the disk, all at once rather than page by
/// page.
void read_ahead(const PackedFrame& frame, const TileRange& range, const SampleList& samples);

}  // namespace ld
