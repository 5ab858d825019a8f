#include "inference/denoiser.h"

#include <unistd.h>

#include <fstream>

#include "dataset/input_tensors.h"
#include "models/networks/layer_network.h"
#include "models/row_strips.h"
#include "ops/memory_pool.h"
#include "weights/model_file.h"

namespace ld {
namespace {

constexpr int64_t kSmallestStrip = int64_t(1) << 20;  // strips cannot get smaller than a few rows anyway
constexpr int64_t kThreads = int64_t(48) << 20;       // stacks, OpenBLAS, oneDNN, the operators' scratch

int64_t resident_bytes() {
  std::ifstream statm("/proc/self/statm");
  int64_t total = 0, resident = 0;
  statm >> total >> resident;
  return resident * sysconf(_SC_PAGESIZE);
}

int64_t frame_bytes(const Frame& frame) {
  return int64_t((frame.samples.size() + frame.alpha.size()) * sizeof(float) + frame.valid.size());
}

int64_t megabytes(int64_t bytes) {
  return (bytes + (1 << 20) - 1) >> 20;
}

/// What the process takes for a frame when strips have this many bytes, without the frame; `base` is what it
/// takes already. The pool keeps up to an eighth more than is in use.
int64_t needed(const Network& network, int64_t base, int64_t strip, int width, int height, int spp) {
  const StripBytes bytes(strip);
  return base + kThreads + network.memory_bytes(spp, height, width) * 9 / 8;
}

/// The largest strips that the budget allows.
int64_t strip_for(const Network& network, int64_t budget, const Frame& frame) {
  const int64_t base = std::max<int64_t>(resident_bytes() - frame_bytes(frame), 0);
  int64_t strip = kStripBytes;
  while (needed(network, base, strip, frame.width, frame.height, frame.spp) > budget) {
    if (strip <= kSmallestStrip)
      fail_usage(
          "a memory budget of {} MB is too small for {}x{} pixels at {} samples (beside the frame itself); "
          "the "
          "smallest is {} MB, of which program and weights take {}",
          budget >> 20, frame.width, frame.height, frame.spp,
          megabytes(needed(network, base, kSmallestStrip, frame.width, frame.height, frame.spp)),
          megabytes(base + kThreads));
    strip = std::max(kSmallestStrip, strip * 4 / 5);
  }
  return strip;
}

/// The scope in which a network runs under the options.
class Run {
 public:
  Run(const Network& network, const Frame& frame, const DenoiseOptions& options)
      : options_(options), strip_(budgeted_strip(network, frame, options)), progress_([this](double share) {
          if (options_.cancel && options_.cancel()) throw Cancelled();
          if (options_.progress) options_.progress(share);
        }) {}

 private:
  static int64_t budgeted_strip(const Network& network, const Frame& frame, const DenoiseOptions& options) {
    if (options.max_memory_bytes <= 0) return StripBytes::current();
    release_memory_pool();  // what earlier frames left may have other sizes
    return strip_for(network, options.max_memory_bytes, frame);
  }

  const torch::InferenceMode no_graph_;
  const DenoiseOptions options_;  // a copy: the caller's may be a temporary
  StripBytes strip_;
  StripProgress progress_;
};

LayerNetwork& layer_network(Network& network) {
  auto* const layer = dynamic_cast<LayerNetwork*>(&network);
  if (layer == nullptr)
    fail_usage("the model's network is '{}', which has no layers to look at; expected 'layer'",
               network.config().name);
  return *layer;
}

}  // namespace

Denoiser::Denoiser(const std::filesystem::path& model)
    : network_(load_model(model)), required_(network_->config().required_features()) {
  network_->eval();
}

Denoiser::~Denoiser() = default;

const NetworkConfig& Denoiser::network_config() const {
  return network_->config();
}

Image Denoiser::denoise(const Frame& frame, const DenoiseOptions& options) const {
  const FrameInput input(frame, network_config().features);
  const Run run(*network_, frame, options);
  return to_image(network_->forward(input).squeeze(0));
}

int64_t Denoiser::least_memory_bytes(int width, int height, int spp) const {
  return needed(*network_, resident_bytes(), kSmallestStrip, width, height, spp);
}

std::vector<LayerPicture> Denoiser::layers(const Frame& frame, const DenoiseOptions& options) const {
  LayerNetwork& network = layer_network(*network_);
  const FrameInput input(frame, network_config().features);
  const Run run(*network_, frame, options);
  const LayerPictures pictures = network.layers(input);
  std::vector<LayerPicture> layers;
  for (int64_t l = 0; l < pictures.radiance.size(1); ++l) {
    const torch::Tensor radiance = pictures.radiance[0][l], alpha = pictures.opacity[0][l],
                        weight = pictures.weight[0][l];
    const torch::Tensor contribution = weight * radiance / alpha.masked_fill(alpha.eq(0), 1);
    layers.push_back({to_image(pictures.unfiltered_radiance[0][l]), to_image(radiance), to_image(alpha),
                      to_image(weight), to_image(contribution)});
  }
  return layers;
}

std::vector<Image> Denoiser::kernels_at(const Frame& frame, int x, int y) const {
  LayerNetwork& network = layer_network(*network_);
  if (x < 0 || y < 0 || x >= frame.width || y >= frame.height)
    fail_usage("there is no pixel ({}, {}) in a frame of {}x{}", x, y, frame.width, frame.height);
  const FrameInput input(frame, network_config().features);
  const Run run(*network_, frame, {});
  const torch::Tensor kernels = network.kernels_at(input, x, y)[0];  // [N, K*K]
  const int64_t side = network.config().kernel_size;
  std::vector<Image> images;
  for (int64_t l = 0; l < kernels.size(0); ++l) images.push_back(to_image(kernels[l].view({1, side, side})));
  return images;
}

}  // namespace ld
