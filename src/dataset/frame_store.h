// The frames and references of one split, kept in memory as half floats up to a budget.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "dataset/augmentation.h"
#include "frame/manifest.h"

namespace ld {

struct StoredFrame {
  HalfFrame frame;
  Image reference;  // [3, H, W] linear
  size_t bytes() const { return frame.bytes() + reference.pixels.size() * sizeof(float); }
};

class FrameStore {
 public:
  /// Reads all headers, so that what does not fit is an error now rather than hours later. Throws Error: no
  /// frames in the split, a missing file or feature, a frame and a reference of different size.
  FrameStore(std::filesystem::path folder, const std::string& split, std::vector<std::string> features,
             uint64_t budget_bytes);

  size_t size() const { return frames_.size(); }
  const std::string& name(size_t index) const { return frames_[index].name; }
  int width(size_t index) const { return sizes_[index].width; }
  int height(size_t index) const { return sizes_[index].height; }

  /// From memory, else from disk (then verified against its checksum and faults logged). Not thread-safe.
  std::shared_ptr<const StoredFrame> get(size_t index);

 private:
  struct Size {
    int width, height;
  };

  std::filesystem::path folder_;
  std::vector<std::string> features_;
  uint64_t budget_bytes_, used_bytes_ = 0;
  std::vector<ManifestFrame> frames_;
  std::vector<Size> sizes_;
  std::vector<std::shared_ptr<const StoredFrame>> memory_;
};

}  // namespace ld
