#include "embed/frame_buffers.h"

#include <algorithm>

#include "core/error.h"

namespace ld {
namespace {

/// Planes one after the other.
LdStrides planar(int width, int height, int channels) {
  const ptrdiff_t row = width, plane = row * height;
  return {channels * plane, plane, row, 1};
}

}  // namespace

void FrameBuffers::set_size(int width, int height, int spp) {
  if (width < 1 || height < 1 || spp < 1)
    fail_usage("a frame of {}x{} pixels with {} samples a pixel; expected at least 1 of each", width, height,
               spp);
  const double samples = double(width) * double(height) * double(spp);
  if (samples * kAllChannels * sizeof(float) > 1e12)
    fail_usage("a frame of {}x{} pixels with {} samples a pixel would take over 1000 GB", width, height, spp);
  features_.clear();
  valid_ = nullptr;
  width_ = width;
  height_ = height;
  spp_ = spp;
}

void FrameBuffers::set_feature(const std::string& name, const float* data, const LdStrides* strides) {
  const Feature& feature = find_feature(name);
  if (width_ == 0)
    fail_usage("feature '{}' was set before the size of the frame; call ld_set_size first", name);
  if (data == nullptr) fail_usage("the buffer of feature '{}' is a null pointer", name);
  features_[name] = {data, strides != nullptr ? *strides : planar(width_, height_, feature.channels)};
}

Frame FrameBuffers::gather(const std::vector<std::string>& features,
                           const std::vector<std::string>& required) const {
  if (width_ == 0) fail_usage("the frame has no size; call ld_set_size first");
  for (const std::string& name : required)
    if (features_.count(name) == 0)
      fail_usage("feature '{}' has no buffer; these weights read it, set it with ld_set_feature", name);
  Frame frame(width_, height_, spp_, frame_channels(features));
  frame.features.clear();
  for (const std::string& name : features)
    if (features_.count(name) > 0) frame.features.push_back(name);
  if (valid_ != nullptr)
    std::transform(valid_, valid_ + frame.valid.size(), frame.valid.begin(),
                   [](uint8_t drawn) { return uint8_t(drawn != 0); });
  for (const std::string& name : frame.features) {
    const auto& [data, strides] = features_.at(name);
    const Feature& feature = find_feature(name);
    for (int s = 0; s < spp_; ++s)
      for (int c = 0; c < feature.channels; ++c) {
        float* out = frame.plane(s, feature.offset + c);
        const float* from = data + s * strides.sample + c * strides.channel;
        for (int y = 0; y < height_; ++y)
          for (int x = 0; x < width_; ++x) *out++ = from[y * strides.row + x * strides.pixel];
      }
  }
  sanitise(frame);
  frame.info.depth_scale = median_depth(frame);
  return frame;
}

void scatter(const Image& picture, float* data, const LdStrides* strides) {
  const LdStrides to = strides != nullptr ? *strides : planar(picture.width, picture.height, 3);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < picture.height; ++y)
      for (int x = 0; x < picture.width; ++x)
        data[c * to.channel + y * to.row + x * to.pixel] = picture.at(c, x, y);
}

}  // namespace ld
