#include "embed/frame_buffers.h"

#include "core/error.h"
#include "core/threads.h"

namespace ld {
namespace {

/// Planes one after the other.
LdStrides planar(int width, int height, int channels) {
  const ptrdiff_t row = width, plane = row * height;
  return {channels * plane, plane, row, 1};
}

StridedArray array_of(const float* data, const LdStrides& strides) {
  return {data, strides.sample, strides.channel, strides.row, strides.pixel};
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
  features_[name] = array_of(data, strides != nullptr ? *strides : planar(width_, height_, feature.channels));
}

FrameBuffers::Part FrameBuffers::part_of(const char* what, int channels, const float* samples,
                                         const LdStrides* strides, float* picture,
                                         const LdStrides* picture_strides) const {
  if (width_ == 0) fail_usage("{} was set before the size of the frame; call ld_set_size first", what);
  if (samples == nullptr) fail_usage("the samples of {} are a null pointer", what);
  if (picture == nullptr) fail_usage("the picture to write of {} is a null pointer", what);
  const LdStrides planes = planar(width_, height_, channels);
  return {array_of(samples, strides != nullptr ? *strides : planes), picture,
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

SampleArrays FrameBuffers::arrays(const std::vector<std::string>& features,
                                  const std::vector<std::string>& required) const {
  if (width_ == 0) fail_usage("the frame has no size; call ld_set_size first");
  for (const std::string& name : required)
    if (features_.count(name) == 0)
      fail_usage("feature '{}' has no buffer; these weights read it, set it with ld_set_feature", name);
  SampleArrays arrays;
  arrays.width = width_;
  arrays.height = height_;
  arrays.spp = spp_;
  for (const std::string& name : features)
    if (features_.count(name) > 0) arrays.features.push_back({&find_feature(name), features_.at(name)});
  for (const Part& part : parts_) arrays.parts.push_back(part.samples);
  if (alpha_) arrays.alpha = alpha_->samples;
  arrays.valid = valid_;
  return arrays;
}

void FrameBuffers::scatter_parts(const DenoisedParts& denoised, int threads) const {
  for (size_t part = 0; part < parts_.size(); ++part)
    scatter(denoised.parts[part], parts_[part].picture, &parts_[part].picture_strides, threads);
  if (alpha_) scatter(denoised.alpha, alpha_->picture, &alpha_->picture_strides, threads);
}

Frame gather(const SampleArrays& arrays, int threads) {
  Frame frame = arrays.make_frame(arrays.width, arrays.height, arrays.spp);
  parallel_for(int64_t(arrays.spp) * arrays.height, threads, [&](int64_t i) {
    const int s = int(i / arrays.height), y = int(i % arrays.height);
    arrays.copy({s, y, 0, arrays.width}, frame, s, size_t(y) * size_t(arrays.width));
  });
  frame.info.depth_scale = arrays.depth_scale > 0 ? arrays.depth_scale : median_depth(frame, threads);
  return frame;
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
