#include "embed/frame_buffers.h"

#include <algorithm>

#include "core/error.h"
#include "core/threads.h"

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
  parts_.clear();
  alpha_.reset();
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

FrameBuffers::Part FrameBuffers::part_of(const char* what, int channels, const float* samples,
                                         const LdStrides* strides, float* picture,
                                         const LdStrides* picture_strides) const {
  if (width_ == 0) fail_usage("{} was set before the size of the frame; call ld_set_size first", what);
  if (samples == nullptr) fail_usage("the samples of {} are a null pointer", what);
  if (picture == nullptr) fail_usage("the picture to write of {} is a null pointer", what);
  const LdStrides planes = planar(width_, height_, channels);
  return {{samples, strides != nullptr ? *strides : planes},
          picture,
          picture_strides != nullptr ? *picture_strides : planes};
}

void FrameBuffers::add_part(const float* samples, const LdStrides* strides, float* picture,
                            const LdStrides* picture_strides) {
  constexpr size_t kMostParts = 1024;
  if (parts_.size() == kMostParts) fail_usage("more than {} parts of the light", kMostParts);
  parts_.push_back(part_of("a part of the light", 3, samples, strides, picture, picture_strides));
}

void FrameBuffers::set_alpha(const float* samples, const LdStrides* strides, float* picture,
                             const LdStrides* picture_strides) {
  alpha_ = part_of("alpha", 1, samples, strides, picture, picture_strides);
}

Frame FrameBuffers::gather(const std::vector<std::string>& features, const std::vector<std::string>& required,
                           int threads) const {
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
  const int64_t row = width_;
  const auto copy_row = [&](const Buffer& buffer, int s, int c, int y, float* plane) {
    const auto& [data, strides] = buffer;
    const float* from = data + s * strides.sample + c * strides.channel + y * strides.row;
    float* out = plane + y * row;
    for (int x = 0; x < width_; ++x) out[x] = from[x * strides.pixel];
  };
  for (size_t part = 0; part < parts_.size(); ++part) frame.add_part("");
  if (alpha_) frame.alpha.resize(frame.valid.size());
  // A row at a time stays in the cache, where the channels of a pixel may lie side by side.
  parallel_for(int64_t(spp_) * height_, threads, [&](int64_t i) {
    const int s = int(i / height_), y = int(i % height_);
    for (const std::string& name : frame.features) {
      const Feature& feature = find_feature(name);
      for (int c = 0; c < feature.channels; ++c)
        copy_row(features_.at(name), s, c, y, frame.plane(s, feature.offset + c));
    }
    for (size_t part = 0; part < parts_.size(); ++part)
      for (int c = 0; c < 3; ++c) copy_row(parts_[part].samples, s, c, y, frame.part_plane(part, s, c));
    if (alpha_) copy_row(alpha_->samples, s, 0, y, frame.alpha.data() + size_t(s) * frame.plane_size());
    Faults faults;
    sanitise(frame, s, size_t(y) * size_t(width_), size_t(width_), faults);
  });
  frame.info.depth_scale = median_depth(frame, threads);
  return frame;
}

void FrameBuffers::scatter_parts(const DenoisedParts& denoised, int threads) const {
  for (size_t part = 0; part < parts_.size(); ++part)
    scatter(denoised.parts[part], parts_[part].picture, &parts_[part].picture_strides, threads);
  if (alpha_) scatter(denoised.alpha, alpha_->picture, &alpha_->picture_strides, threads);
}

void scatter(const Image& picture, float* data, const LdStrides* strides, int threads) {
  const LdStrides to =
      strides != nullptr ? *strides : planar(picture.width, picture.height, picture.channels);
  parallel_for(picture.height, threads, [&](int64_t y) {
    for (int c = 0; c < picture.channels; ++c)
      for (int x = 0; x < picture.width; ++x)
        data[c * to.channel + y * to.row + x * to.pixel] = picture.at(c, x, int(y));
  });
}

}  // namespace ld
