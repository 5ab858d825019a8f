// Sizes of a network, as the `network:` section of a config and the metadata of a weight file hold them. The
// defaults are the published network ([MH20] section 3 and appendix B).
#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <vector>

#include "core/config_visitor.h"

namespace ld {

struct UNetConfig {
  std::vector<std::vector<int64_t>> encoder = {
      {64, 64}, {128}, {256}, {512}, {512}};  // channels of its blocks, a 2x2 max-pool after each
  std::vector<int64_t> bottleneck = {512};    // channels of the convolutions at the lowest resolution
  /// Channels of its blocks, as many as the encoder has, upsampling before each.
  std::vector<std::vector<int64_t>> decoder = {{512, 512}, {256, 256}, {128, 128}, {128, 128}, {128, 128}};
  int64_t context = 128;                // channels of the last 3x3 convolution, which has no activation
  std::string upsampling = "bilinear";  // between the decoder's blocks

  int64_t resolutions() const { return static_cast<int64_t>(decoder.size()) + 1; }

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("encoder", encoder, Range{1, 4096});
    v.field("bottleneck", bottleneck, Range{1, 4096});
    v.field("decoder", decoder, Range{1, 4096});
    v.field("context", context, Range{1, 4096});
    v.field("upsampling", upsampling, {"bilinear", "nearest"});
  }
};

/// Of networks that read light at half resolution (models/super_resolution.h, models/light_kpcn.h).
struct SuperResolutionConfig {
  std::vector<int64_t> convolutions = {64, 32};  // channels of the hidden ones, the first 5x5, all others 3x3
  std::string activation = "tanh";               // behind the hidden ones
  std::string reads = "both";                    // what: the light, the guides or both
  int64_t denoiser = 32;                         // channels of the denoiser's hidden convolutions

  bool light() const { return reads != "guides"; }
  bool guides() const { return reads != "light"; }

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("convolutions", convolutions, Range{1, 4096});
    v.field("activation", activation, {"tanh", "relu"});
    v.field("reads", reads, {"light", "guides", "both"});
    v.field("denoiser", denoiser, Range{1, 4096});
  }
};

/// Instead of a list of features: those that all frames of the training split hold and that vary in it
/// (dataset/varying_features.h). Only a training finds out which; its resolved configuration and its weights
/// hold the list.
inline constexpr const char* kAutoFeatures = "auto";

/// Instead of a network's name: the network of the weights that the training begins with, sizes and all,
/// without those of its optional features that the data lack. Likewise resolved when a training begins.
inline constexpr const char* kNetworkOfInit = "init";

/// One struct for all networks; keys that a network has no use for are ignored, except where that would
/// surprise (make_network).
struct NetworkConfig {
  std::string name = "layer";  // which network (docs/networks.md)
  /// What it reads of each sample (docs/data_format.md); auto: what all frames hold and what varies in them.
  std::vector<std::string> features = {"radiance",  "normal", "depth", "albedo", "specular",
                                       "roughness", "motion", "coc",   "lens",   "time"};
  /// Features that a frame may lack: zeros take their place. data.drop lets a training see that.
  std::vector<std::string> optional;
  int64_t layers = 2;                 // how many, in networks that have layers
  std::string compositing = "alpha";  // of the layers: front to back, or weighted ([MH20] section 3.1)
  /// Resolutions of "optimized" and "pixel_pyramid": full, 1/2, 1/4, ... ([MH20] section 6).
  int64_t levels = 3;
  int64_t kernel_size = 17;                            // taps a side; an odd number
  std::vector<int64_t> sample_reducer = {32, 32, 32};  // outputs of its layers; the last is the embedding
  std::vector<int64_t> sample_partitioner = {32, 16};  // outputs of its hidden layers; the last has `layers`
  std::vector<int64_t> kernel_generator = {
      128, 128};                           // outputs of its hidden layers; the last has kernel_size squared
  std::vector<int64_t> history = {16};     // of "layer_history": hidden layers of what weighs the history
  SuperResolutionConfig super_resolution;  // of "espcn_kpcn"
  UNetConfig unet;
  bool recurrence = true;  // of "recurrent"; false: every frame is a first one, for comparison
  /// The network sees radiance as exposed so that the picture's log-average luminance is middle grey
  /// (models/exposure.h): the result then scales with the radiance exactly.
  bool exposure_normalisation = false;
  /// The network sees of each pixel the mean of its samples alone, so that an ordinary picture will do
  /// (models/pixel_mean.h). Networks on pixels only.
  bool means = false;
  std::string demodulation = "none";  // by the albedo, which keeps textures sharp (models/demodulation.h)
  /// Kernel logits are kept within (-c, c) by c x / (c + |x|) (ops/fully_connected.h); 0: not bounded, as
  /// [MH20] has it. A kernel of one tap alone has no gradient left to learn from.
  double logit_bound = 0;
  bool rejection = false;  // a pixel with a firefly can count less than others (models/rejection.h)
  std::string initialisation = "xavier";  // of the weights of a new training (models/initialise.h)
  double initial_kernel = 0;              // deviation of the Gaussian that kernels begin as, pixels; 0: none

  bool of_init() const { return name == kNetworkOfInit; }
  bool auto_features() const { return features == std::vector<std::string>{kAutoFeatures}; }

  /// The features that are not optional.
  std::vector<std::string> required_features() const {
    std::vector<std::string> required;
    for (const std::string& feature : features)
      if (std::find(optional.begin(), optional.end(), feature) == optional.end()) required.push_back(feature);
    return required;
  }

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("name", name);
    v.field_or_word("features", features, kAutoFeatures);
    v.field("optional", optional);
    v.field("layers", layers, Range{1, 8});
    v.field("compositing", compositing, {"alpha", "weighted"});
    v.field("levels", levels, Range{1, 16});
    v.field("kernel_size", kernel_size, Range{1, 31});
    v.field("sample_reducer", sample_reducer, Range{1, 4096});
    v.field("sample_partitioner", sample_partitioner, Range{1, 4096});
    v.field("kernel_generator", kernel_generator, Range{1, 4096});
    v.field("history", history, Range{1, 4096});
    v.section("super_resolution", super_resolution);
    v.section("unet", unet);
    v.field("recurrence", recurrence);
    v.field("exposure_normalisation", exposure_normalisation);
    v.field("means", means);
    v.field("demodulation", demodulation, {"none", "albedo"});
    v.field("logit_bound", logit_bound, Range{0, 1000});
    v.field("rejection", rejection);
    v.field("initialisation", initialisation, {"xavier", "he"});
    v.field("initial_kernel", initial_kernel, Range{0, 100});
  }
};

}  // namespace ld
