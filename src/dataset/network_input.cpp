#include "dataset/network_input.h"

#include <algorithm>
#include <cstring>

#include "core/error.h"
#include "frame/encoding.h"

namespace ld {
namespace {

/// Writes the encoded features of one sample to `out` [F, H, W].
void encode_sample(const Frame& frame, int sample, const std::vector<std::string>& features, float* out) {
  const size_t pixels = frame.plane_size();
  const uint8_t* valid = frame.valid_plane(sample);
  for (const std::string& name : features) {
    const Feature& feature = find_feature(name);
    for (int c = 0; c < feature.channels; ++c, out += pixels) {
      encode(feature, frame.info.depth_scale, frame.plane(sample, feature.offset + c), out, pixels);
      for (size_t p = 0; p < pixels; ++p)
        if (valid[p] == 0) out[p] = 0;
    }
  }
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
  const int channels = channel_count(features);
  NetworkInput input;
  input.features = torch::zeros({batch, spp, channels, height, width});
  input.radiance = torch::zeros({batch, spp, 3, height, width});
  input.valid = torch::zeros({batch, spp, 1, height, width});
  const size_t pixels = frames[0].plane_size();
  for (size_t b = 0; b < frames.size(); ++b) {
    for (int s = 0; s < frames[b].spp; ++s) {
      const size_t sample = b * static_cast<size_t>(spp) + static_cast<size_t>(s);
      encode_sample(frames[b], s, features,
                    input.features.data_ptr<float>() + sample * static_cast<size_t>(channels) * pixels);
      std::copy_n(frames[b].plane(s, kRadianceOffset), 3 * pixels,
                  input.radiance.data_ptr<float>() + sample * 3 * pixels);
      std::copy_n(frames[b].valid_plane(s), pixels, input.valid.data_ptr<float>() + sample * pixels);
    }
  }
  return input;
}

Batch make_batch(const std::vector<FrameCrop>& crops, const std::vector<std::string>& features) {
  if (crops.empty()) fail("a batch needs at least one crop, found none");
  const int width = crops[0].augmentation.result_width(), height = crops[0].augmentation.result_height();
  int spp = 0;
  for (const auto& [frame, augmentation] : crops) {
    if (augmentation.result_width() != width || augmentation.result_height() != height)
      fail("crops of one batch must have one size, found {}x{} and {}x{}", width, height,
           augmentation.result_width(), augmentation.result_height());
    spp = std::max(spp, frame->spp);
  }
  const auto count = static_cast<int64_t>(crops.size());
  const int channels = channel_count(features);
  // Filled by hand: LibTorch would start threads of its own for this thread.
  Batch batch;
  batch.input.features = torch::empty({count, spp, channels, height, width});
  batch.input.radiance = torch::empty({count, spp, 3, height, width});
  batch.input.valid = torch::empty({count, spp, 1, height, width});
  batch.reference = torch::empty({count, 3, height, width});
  const size_t pixels = static_cast<size_t>(width) * static_cast<size_t>(height);
  for (size_t b = 0; b < crops.size(); ++b) {
    const auto planes_of = [&](torch::Tensor& tensor, int planes) {
      return tensor.data_ptr<float>() + b * static_cast<size_t>(spp * planes) * pixels;
    };
    const CropPlanes planes = {planes_of(batch.input.features, channels), planes_of(batch.input.radiance, 3),
                               planes_of(batch.input.valid, 1),
                               batch.reference.data_ptr<float>() + b * 3 * pixels};
    read_crop(*crops[b].frame, crops[b].augmentation, features, planes);
    const auto drawn = static_cast<size_t>(crops[b].frame->spp), missing = static_cast<size_t>(spp) - drawn;
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
  const torch::Tensor plain = tensor.detach().to(torch::kFloat32).contiguous();
  if (plain.dim() != 3) fail("an image has the shape [C, H, W], found {} dimensions", plain.dim());
  Image image(static_cast<int>(plain.size(2)), static_cast<int>(plain.size(1)),
              static_cast<int>(plain.size(0)));
  std::memcpy(image.pixels.data(), plain.data_ptr<float>(), image.pixels.size() * sizeof(float));
  return image;
}

}  // namespace ld
