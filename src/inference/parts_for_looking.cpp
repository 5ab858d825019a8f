#include "inference/parts_for_looking.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

namespace ld {
namespace {

/// A part of the colour and, where it is not empty, a further plane.
PicturePart layer_part(const std::string& name, const Image& colour, const Image& further,
                       const char* channel) {
  Image planes(colour.width, colour.height, 3 + further.channels);
  const auto end = std::copy(colour.pixels.begin(), colour.pixels.end(), planes.pixels.begin());
  std::copy(further.pixels.begin(), further.pixels.end(), end);
  std::vector<std::string> channels = {"R", "G", "B"};
  if (further.channels > 0) channels.emplace_back(channel);
  return {name, std::move(planes), channels};
}

}  // namespace

std::vector<PicturePart> parts_for_looking(const DenoiseJob& job, const Denoiser& denoiser,
                                           const Frame& frame, DenoiseOptions how) {
  std::vector<PicturePart> parts;
  if (job.layers || job.contributions || job.unfiltered) {
    how.progress = nullptr;  // the picture is what takes long
    const std::vector<LayerPicture> layers = denoiser.layers(frame, how);
    for (size_t l = 0; l < layers.size(); ++l) {
      const std::string name = fmt::format("layer{}", l);
      const LayerPicture& layer = layers[l];
      if (job.layers) parts.push_back(layer_part(name, layer.radiance, layer.alpha, "A"));
      if (job.contributions)
        parts.push_back(layer_part(name + ".contribution", layer.contribution, layer.weight, "weight"));
      if (job.unfiltered) parts.push_back(layer_part(name + ".unfiltered", layer.unfiltered, {}, ""));
    }
  }
  for (const auto& [x, y] : job.kernels_at) {
    const std::vector<Image> kernels = denoiser.kernels_at(frame, x, y);
    for (size_t l = 0; l < kernels.size(); ++l)
      parts.push_back({fmt::format("kernel.{}.{}.layer{}", x, y, l),
                       kernels[l],
                       {"Y"},
                       x - kernels[l].width / 2,
                       y - kernels[l].height / 2});
  }
  return parts;
}

}  // namespace ld
