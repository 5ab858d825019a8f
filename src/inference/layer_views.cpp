#include "inference/layer_views.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "models/graphs/shared_graph.h"
#include "models/network_numbers.h"
#include "runtime/fully_connected_rows.h"

namespace ld {
namespace {

Image planes_of(const Image& image, int first, int count) {
  Image part(image.width, image.height, count);
  std::copy_n(image.plane(first), part.pixels.size(), part.pixels.begin());
  return part;
}

/// out = a * b, pixel by pixel.
void multiply(const float* a, const float* b, size_t count, float* out) {
  std::transform(a, a + count, b, out, std::multiplies<>());
}

/// What of the output's colour is the layer's: what the layers in front let through, times its opacity
/// ([MH20] eq. 5). `filtered` [N, C + 2], the opacity before the transmittance.
std::vector<Image> alpha_weights(const Image& filtered, int layers) {
  const size_t count = filtered.plane_size();
  const int channels = filtered.channels / layers;
  std::vector<float> visible(count, 1.0F);
  std::vector<Image> weights;
  for (int l = 0; l < layers; ++l) {
    const int end = channels * (l + 1);
    weights.emplace_back(filtered.width, filtered.height, 1);
    multiply(visible.data(), filtered.plane(end - 2), count, weights.back().plane(0));
    multiply(visible.data(), filtered.plane(end - 1), count, visible.data());
  }
  return weights;
}

/// What the layer adds to the output: weight * colour, the colour being radiance / opacity.
Image contribution_of(const LayerPicture& layer) {
  Image contribution(layer.radiance.width, layer.radiance.height, 3);
  const float* alpha = layer.alpha.plane(0);
  for (int c = 0; c < 3; ++c)
    for (size_t p = 0; p < contribution.plane_size(); ++p)
      contribution.plane(c)[p] =
          layer.weight.plane(0)[p] * layer.radiance.plane(c)[p] / (alpha[p] == 0 ? 1.0F : alpha[p]);
  return contribution;
}

/// The same of demodulated light, with the texture (models/demodulation.h): the layer's part of the picture
/// as it is becomes `contribution`'s.
void modulate(const LayerPicture& layer, const Image& demodulated, const Image& factors,
              Image& contribution) {
  const float *alpha = layer.alpha.plane(0), *beta = factors.plane(3);
  for (size_t p = 0; p < contribution.plane_size(); ++p) {
    const float share = layer.weight.plane(0)[p] / (alpha[p] == 0 ? 1.0F : alpha[p]);
    for (int c = 0; c < 3; ++c) {
      float& plain = contribution.plane(c)[p];
      if (plain <= float(kLargestModulated))
        plain += beta[p] * (factors.plane(c)[p] * share * demodulated.plane(c)[p] - plain);
    }
  }
}

}  // namespace

std::vector<LayerPicture> layer_pictures(const NetworkConfig& config, const std::vector<Image>& outputs) {
  const Image &unfiltered = outputs[0], &filtered = outputs[1];
  const int layers = int(config.layers), colours = unfiltered.channels / layers,
            channels = filtered.channels / layers;
  const bool demodulated = config.demodulation != "none";
  std::vector<Image> weights;
  if (config.compositing == "alpha")
    weights = alpha_weights(filtered, layers);
  else
    for (int l = 0; l < layers; ++l) weights.push_back(planes_of(outputs[2], l, 1));
  std::vector<LayerPicture> pictures;
  for (int l = 0; l < layers; ++l) {
    const int plain = colours - 3;  // the radiance as it is comes last
    LayerPicture layer{planes_of(unfiltered, colours * l + plain, 3),
                       planes_of(filtered, channels * l + plain, 3),
                       planes_of(filtered, channels * l + colours, 1),
                       std::move(weights[size_t(l)]),
                       {}};
    layer.contribution = contribution_of(layer);
    if (demodulated)
      modulate(layer, planes_of(filtered, channels * l, 3), outputs.back(), layer.contribution);
    pictures.push_back(std::move(layer));
  }
  return pictures;
}

std::vector<Image> layer_kernels(const NetworkConfig& config, const NamedWeights& weights,
                                 Execution& execution, const Frame& frame, int x, int y) {
  const auto layers = int(config.layers), side = int(config.kernel_size);
  const int64_t embedding = config.sample_reducer.back(), context = config.unet.context;
  std::vector<float> log_n, embeddings, shared;
  execution.run(frame, {}, [&](int64_t begin, int64_t end) {
    if (y < begin || y >= end) return;
    for (int64_t l = 0; l < layers; ++l) log_n.push_back(execution.row(0, l, y)[x]);
    for (int64_t c = 0; c < layers * embedding; ++c) embeddings.push_back(execution.row(1, c, y)[x]);
    for (int64_t c = 0; c < context; ++c) shared.push_back(execution.row(2, c, y)[x]);
  });

  const TileNetwork network = tile_network(make_splat(config, /*joint=*/false).generator, weights, embedding,
                                           config.kernel_size * config.kernel_size);
  TileNetwork::Scratch scratch = network.make_scratch(kPixelStep, false);
  // A tile of one pixel.
  for (int64_t c = 0; c < context; ++c) scratch.shared[c * scratch.pitch] = shared[size_t(c)];
  network.begin_tile(scratch, 1);
  std::vector<Image> kernels;
  double largest = -std::numeric_limits<double>::infinity();
  for (int64_t l = 0; l < layers; ++l) {
    for (int64_t c = 0; c < embedding; ++c)
      scratch.x[c * scratch.pitch] = embeddings[size_t(l * embedding + c)];
    network.forward(scratch, 1);
    kernels.emplace_back(side, side, 1);
    for (int tap = 0; tap < side * side; ++tap) {
      float& exponent = kernels.back().pixels[size_t(tap)];
      exponent = scratch.a.back()[tap * scratch.pitch] + log_n[size_t(l)];
      largest = std::max(largest, double(exponent));
    }
  }
  if (std::isinf(largest)) largest = 0;  // no samples: all of them are e^-infinity
  double sum = 0;
  for (Image& kernel : kernels)
    for (float& share : kernel.pixels) sum += share = float(std::exp(share - largest));
  for (Image& kernel : kernels)
    for (float& share : kernel.pixels) share = sum > 0 ? float(share / sum) : 0.0F;
  return kernels;
}

}  // namespace ld
