#include "dataset/input_tensors.h"

#include <ATen/Parallel.h>

#include <algorithm>
#include <cstring>

#include "core/error.h"
#include "frame/encoding.h"

namespace ld {
namespace {

/// A frame encoded into sample planes; on all threads.
void encode_frame(const Frame& frame, const std::vector<std::string>& names, float* features, float* radiance,
                  float* valid) {
  std::vector<std::pair<const Feature*, int>> channels;  // of the network, and their places in the frame
  for (const std::string& name : names)
    for (int c = 0; c < find_feature(name).channels; ++c)
      channels.emplace_back(&find_feature(name), find_feature(name).offset + c);
  const auto pixels = int64_t(frame.plane_size()), count = int64_t(channels.size());
  const int64_t planes = count + 4;
  at::parallel_for(0, frame.spp * planes, 1, [&](int64_t first, int64_t last) {
    for (int64_t i = first; i < last; ++i) {
      const auto s = int(i / planes);
      const int64_t plane = i % planes;
      const uint8_t* drawn = frame.valid_plane(s);
      if (plane < count) {
        const auto& [feature, channel] = channels[size_t(plane)];
        float* out = features + (s * count + plane) * pixels;
        if (channel >= frame.channels) {  // frames end with the last feature that they hold
          std::fill_n(out, pixels, 0.0F);
          continue;
        }
        encode(*feature, frame.info.depth_scale, frame.plane(s, channel), out, size_t(pixels));
        for (int64_t p = 0; p < pixels; ++p)
          if (drawn[p] == 0) out[p] = 0;
      } else if (plane < count + 3) {
        const auto c = int(plane - count);
        std::copy_n(frame.plane(s, kRadianceOffset + c), pixels, radiance + (s * 3 + c) * pixels);
      } else {
        std::copy_n(drawn, pixels, valid + s * pixels);
      }
    }
  });
}

}  // namespace

NetworkInput make_network_input(const std::vector<Frame>& frames, const std::vector<std::string>& features) {
  if (frames.empty()) fail("a batch needs at least one frame, found none");
  const int width = frames[0].width, height = frames[0].height;
  int spp = 0;
  for (const Frame& frame : frames) {
    if (frame.width != width || frame.height != height)
      fail("frames of one batch must have one size, found {}x{} and {}x{}", width, height, frame.width,
           frame.height);
    if (!(frame.info.depth_scale > 0)) fail("a frame without a depth scale; expected a number above 0");
    spp = std::max(spp, frame.spp);
  }
  if (spp == 0) fail("a frame without samples cannot enter a sample network; render at 1 spp or more");

  const auto batch = static_cast<int64_t>(frames.size());
  NetworkInput input;
  input.features = torch::zeros({batch, spp, channel_count(features), height, width});
  input.radiance = torch::zeros({batch, spp, 3, height, width});
  input.valid = torch::zeros({batch, spp, 1, height, width});
  for (int64_t b = 0; b < batch; ++b)
    encode_frame(frames[size_t(b)], features, input.features[b].data_ptr<float>(),
                 input.radiance[b].data_ptr<float>(), input.valid[b].data_ptr<float>());
  return input;
}

Batch make_batch(const std::vector<FrameCrop>& crops, const std::vector<std::string>& features,
                 int64_t clip) {
  if (crops.empty()) fail("a batch needs at least one crop, found none");
  if (clip < 1 || static_cast<int64_t>(crops.size()) % clip != 0)
    fail("a batch of {} crops is not one of whole clips of {}", crops.size(), clip);
  const int width = crops[0].augmentation.result_width(), height = crops[0].augmentation.result_height();
  int spp = 0;
  for (const FrameCrop& crop : crops) {
    const Augmentation& augmentation = crop.augmentation;
    if (augmentation.result_width() != width || augmentation.result_height() != height)
      fail("crops of one batch must have one size, found {}x{} and {}x{}", width, height,
           augmentation.result_width(), augmentation.result_height());
    spp = std::max(spp, static_cast<int>(crop.sample_count()));
  }
  const auto count = static_cast<int64_t>(crops.size());
  const int channels = channel_count(features);
  // Filled by hand: LibTorch would start threads of its own for this thread.
  Batch batch;
  batch.clip = clip;
  batch.input.features = torch::empty({count, spp, channels, height, width});
  batch.input.radiance = torch::empty({count, spp, 3, height, width});
  batch.input.valid = torch::empty({count, spp, 1, height, width});
  batch.reference = torch::empty({count, 3, height, width});
  if (!crops[0].noisy.empty()) batch.noisy = torch::empty({count, 3, height, width});
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  for (size_t b = 0; b < crops.size(); ++b) {
    const auto planes_of = [&](torch::Tensor& tensor, int planes) {
      return tensor.data_ptr<float>() + b * static_cast<size_t>(spp * planes) * pixels;
    };
    const CropPlanes planes = {
        planes_of(batch.input.features, channels), planes_of(batch.input.radiance, 3),
        planes_of(batch.input.valid, 1), batch.reference.data_ptr<float>() + b * 3 * pixels,
        batch.noisy.defined() ? batch.noisy.data_ptr<float>() + b * 3 * pixels : nullptr};
    read_crop(*crops[b].frame, crops[b].augmentation, features, planes, crops[b].samples, crops[b].targets,
              crops[b].noisy);
    const size_t drawn = crops[b].sample_count(), missing = static_cast<size_t>(spp) - drawn;
    for (const auto& [plane, count_of_planes] :
         {std::pair(planes.features, channels), std::pair(planes.radiance, 3), std::pair(planes.valid, 1)})
      std::fill_n(plane + drawn * static_cast<size_t>(count_of_planes) * pixels,
                  missing * static_cast<size_t>(count_of_planes) * pixels, 0.0F);
  }
  return batch;
}

torch::Tensor to_tensor(const Image& image) {
  torch::Tensor tensor = torch::empty({image.channels, image.height, image.width});
  std::memcpy(tensor.data_ptr<float>(), image.pixels.data(), image.pixels.size() * sizeof(float));
  return tensor;
}

Image to_image(const torch::Tensor& tensor) {
  const torch::Tensor plain = tensor.detach().to(torch::kCPU, torch::kFloat32).contiguous();
  if (plain.dim() != 3) fail("an image has the shape [C, H, W], found {} dimensions", plain.dim());
  Image image(static_cast<int>(plain.size(2)), static_cast<int>(plain.size(1)),
              static_cast<int>(plain.size(0)));
  std::memcpy(image.pixels.data(), plain.data_ptr<float>(), image.pixels.size() * sizeof(float));
  return image;
}

}  // namespace ld
