// The caller's buffers, on their way to a frame.
#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "frame/frame.h"
#include "layered_denoiser/layered_denoiser.h"

namespace ld {

class FrameBuffers {
 public:
  /// Forgets all buffers. Throws UsageError for a size below 1 or one whose samples no memory could hold.
  void set_size(int width, int height, int spp);

  /// Throws UsageError before set_size(), for a name that the schema does not have, and for a null pointer.
  void set_feature(const std::string& name, const float* data, const LdStrides* strides);
  void set_valid(const uint8_t* valid) { valid_ = valid; }

  int width() const { return width_; }
  int height() const { return height_; }

  /// A frame with those of `features` that were set, sanitised. Throws UsageError when a required one was
  /// not, naming it.
  Frame gather(const std::vector<std::string>& features, const std::vector<std::string>& required,
               int threads) const;

 private:
  struct Buffer {
    const float* data;
    LdStrides strides;
  };
  int width_ = 0, height_ = 0, spp_ = 0;
  std::map<std::string, Buffer> features_;
  const uint8_t* valid_ = nullptr;
};

/// Writes a picture [3, H, W] to the caller's memory.
void scatter(const Image& picture, float* data, const LdStrides* strides, int threads);

}  // namespace ld
