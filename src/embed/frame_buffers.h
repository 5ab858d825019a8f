// The caller's buffers.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "frame/sample_arrays.h"
#include "inference/denoiser.h"
#include "layered_denoiser/layered_denoiser.h"

namespace ld {

class FrameBuffers {
 public:
  /// Forgets all buffers. Throws UsageError for a size below 1 or one whose samples no memory could hold.
  void set_size(int width, int height, int spp);

  /// Throws UsageError before set_size(), for a name that the schema does not have, and for a null pointer.
  void set_feature(const std::string& name, const float* data, const LdStrides* strides);
  void set_valid(const uint8_t* valid) { valid_ = valid; }
  /// Likewise. What is filtered goes to `picture`.
  void add_part(const float* samples, const LdStrides* strides, float* picture,
                const LdStrides* picture_strides);
  void set_alpha(const float* samples, const LdStrides* strides, float* picture,
                 const LdStrides* picture_strides);

  int width() const { return width_; }
  int height() const { return height_; }

  /// Those of `features` that were set, and all parts, where they lie. Throws UsageError when a required one
  /// was not, naming it.
  SampleArrays arrays(const std::vector<std::string>& features,
                      const std::vector<std::string>& required) const;

  /// Writes the filtered parts, and alpha, to where they go.
  void scatter_parts(const DenoisedParts& denoised, int threads) const;

 private:
  /// In and out.
  struct Part {
    StridedArray samples;
    float* picture;
    LdStrides picture_strides;
  };
  Part part_of(const char* what, int channels, const float* samples, const LdStrides* strides, float* picture,
               const LdStrides* picture_strides) const;
  int width_ = 0, height_ = 0, spp_ = 0;
  std::map<std::string, StridedArray> features_;
  std::vector<Part> parts_;
  std::optional<Part> alpha_;
  const uint8_t* valid_ = nullptr;
};

/// A frame of such, sanitised, with a depth scale.
Frame gather(const SampleArrays& arrays, int threads);

/// Writes a picture [C, H, W] to the caller's memory.
void scatter(const Image& picture, float* data, const LdStrides* strides, int threads);

}  // namespace ld
