#include "models/check_network.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/error.h"
#include "frame/schema.h"

namespace ld {
namespace {

constexpr size_t kMostResolutions = 15;  // pictures are padded to multiples of 2^15 at most
constexpr size_t kMostWidths = 100;      // a damaged file asks for no more modules than fit in little memory

const std::map<std::string, NetworkTraits>& networks() {
  static const std::map<std::string, NetworkTraits> traits = {
#define LD_NETWORK(name, type, traits) {name, traits},
#include "models/networks.def"
#undef LD_NETWORK
  };
  return traits;
}

void check_widths(const char* key, const std::vector<int64_t>& widths, bool may_be_empty) {
  if (widths.empty() && !may_be_empty) fail_usage("network.{} is empty, expected at least one width", key);
  if (widths.size() > kMostWidths)
    fail_usage("network.{} has {} widths, expected at most {}", key, widths.size(), kMostWidths);
  for (const int64_t width : widths)
    if (width < 1) fail_usage("network.{} has a width of {}, expected at least 1", key, width);
}

void check_choice(const char* key, const std::string& value, const std::vector<std::string>& choices) {
  if (std::find(choices.begin(), choices.end(), value) != choices.end()) return;
  const std::string nearest = nearest_word(value, choices);
  fail_usage("unknown network.{} '{}'; {}choose from {}", key, value,
             nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest), fmt::join(choices, ", "));
}

/// Of networks in two stages; of others, that nobody asks for them.
void check_super_resolution(const NetworkConfig& config) {
  const SuperResolutionConfig& stages = config.super_resolution;
  const auto reads = [&](const char* feature) {
    return config.auto_features() || first_channel(config.features, feature) >= 0;
  };
  if (network_traits(config.name).upscaling == 1) {
    if (!config.auto_features() && reads("half_radiance"))
      fail_usage(
          "network.features names 'half_radiance', but network '{}' reads light at full resolution; leave it "
          "out or use 'espcn_kpcn'",
          config.name);
    return;
  }
  if (!config.auto_features() && reads("radiance") == reads("half_radiance"))
    fail_usage(
        "network.features: network '{}' reads light at half resolution, either 'half_radiance', which the "
        "frames then hold, or the mean of 2x2 pixels of 'radiance'; name one of the two",
        config.name);
  if (stages.guides() && !config.auto_features() && channel_count(config.features) == 3)
    fail_usage(
        "network.features has light alone, but network.super_resolution.reads is '{}'; add guides (normal, "
        "depth, albedo, roughness) or say 'light'",
        stages.reads);
  if (config.exposure_normalisation)
    fail_usage(
        "network.exposure_normalisation is true, but network '{}' predicts colours as they are; leave it out",
        config.name);
}

/// Keys that somebody set to choose between networks, on a network that cannot follow.
void check_use(const NetworkConfig& config) {
  const NetworkTraits& network = network_traits(config.name);
  const bool has_layers = network.sources == Sources::layers;
  const NetworkConfig unset;
  if (!has_layers && config.compositing != unset.compositing)
    fail_usage("network.compositing is '{}', but network '{}' has no layers to composite; leave it out",
               config.compositing, config.name);
  if (!has_layers && config.layers != unset.layers)
    fail_usage("network.layers is {}, but network '{}' has no layers; leave it out", config.layers,
               config.name);
  if (!network.has_levels && config.levels != unset.levels)
    fail_usage(
        "network.levels is {}, but network '{}' works at one resolution; leave it out or use 'optimized' or "
        "'pixel_pyramid'",
        config.levels, config.name);
  if (!network.remembers && config.history != unset.history)
    fail_usage("network.history is given, but network '{}' keeps nothing from frame to frame; leave it out",
               config.name);
  if (network.remembers &&
      std::find(config.optional.begin(), config.optional.end(), "flow") != config.optional.end())
    fail_usage(
        "network.optional names 'flow', but network '{}' would take a frame without it for one in which "
        "nothing "
        "moves; leave it out of network.optional",
        config.name);
  if (!config.recurrence && !network.in_powers)
    fail_usage("network.recurrence is false, but network '{}' has no recurrent blocks; leave it out",
               config.name);
  if (network.filter == Filter::none) {
    const auto refuse = [&](const char* key, const char* why) {
      fail_usage("network.{} is given, but network '{}' {}; leave it out", key, config.name, why);
    };
    if (config.demodulation != "none") refuse("demodulation", "divides by the albedo by itself");
    if (config.means) refuse("means", "sees means of the samples anyway");
    if (config.exposure_normalisation) refuse("exposure_normalisation", "sees powers of the light");
    if (config.initial_kernel > 0 || config.logit_bound > 0)
      refuse(config.logit_bound > 0 ? "logit_bound" : "initial_kernel", "has no kernels");
  }
  if (config.rejection && network.filter != Filter::splat)
    fail_usage(
        "network.rejection is true, but network '{}' sends nothing that could count less; leave it out",
        config.name);
  if (config.means && network.sources != Sources::pixels)
    fail_usage(
        "network.means is true, but network '{}' works on samples; use 'pixel_gather' or 'pixel_splat', or "
        "leave it out",
        config.name);
  check_super_resolution(config);
  if (network.has_levels && (config.levels < 1 || config.levels > config.unet.resolutions()))
    fail_usage("network.levels is {}, expected 1 to {}: the U-net has so many resolutions", config.levels,
               config.unet.resolutions());
}

}  // namespace

std::vector<std::string> network_names() {
  std::vector<std::string> names;
  for (const auto& [name, traits] : networks()) names.push_back(name);
  return names;
}

const NetworkTraits& network_traits(const std::string& name) {
  check_choice("name", name, network_names());
  return networks().at(name);
}

// What the reader of the file cannot see: that the sizes fit together. Weight files bring configurations too.
void check_network(const NetworkConfig& config) {
  check_choice("name", config.name, network_names());
  check_choice("compositing", config.compositing, {"alpha", "weighted"});
  check_choice("unet.upsampling", config.unet.upsampling, {"bilinear", "nearest"});
  check_choice("demodulation", config.demodulation, {"none", "albedo"});
  check_choice("initialisation", config.initialisation, {"xavier", "he"});
  if (config.features.empty())
    fail_usage("network.features is empty, expected some of {}", fmt::join(auto_feature_names(), ", "));
  std::set<std::string> seen;
  for (const std::string& feature : config.features)
    if (require_network_feature(feature); !seen.insert(feature).second)
      fail_usage("network.features names '{}' twice, expected each feature once", feature);
  for (const std::string& feature : config.optional)
    if (!config.auto_features() && seen.count(feature) == 0)
      fail_usage("network.optional names '{}', which is not among network.features ({})", feature,
                 fmt::join(config.features, ", "));
  if (config.demodulation != "none" && !config.auto_features() &&
      first_channel(config.features, "albedo") < 0)
    fail_usage(
        "network.demodulation is '{}', but network.features ({}) has no albedo to divide by; add albedo or "
        "set "
        "network.demodulation=none",
        config.demodulation, fmt::join(config.features, ", "));
  if (!(config.logit_bound >= 0))
    fail_usage("network.logit_bound is {}, expected at least 0", config.logit_bound);
  if (config.layers < 1) fail_usage("network.layers is {}, expected at least 1", config.layers);
  if (config.kernel_size < 1 || config.kernel_size % 2 == 0)
    fail_usage("network.kernel_size is {}, expected an odd number, so that a kernel has a centre",
               config.kernel_size);
  check_widths("sample_reducer", config.sample_reducer, false);
  check_widths("sample_partitioner", config.sample_partitioner, true);
  check_widths("kernel_generator", config.kernel_generator, true);
  check_widths("history", config.history, true);
  check_choice("super_resolution.activation", config.super_resolution.activation, {"tanh", "relu"});
  check_choice("super_resolution.reads", config.super_resolution.reads, {"light", "guides", "both"});
  check_widths("super_resolution.convolutions", config.super_resolution.convolutions, false);
  check_widths("super_resolution.denoiser", {config.super_resolution.denoiser}, false);
  const UNetConfig& unet = config.unet;
  if (unet.encoder.empty()) fail_usage("network.unet.encoder is empty, expected at least one block");
  if (unet.encoder.size() > kMostResolutions)
    fail_usage("network.unet.encoder has {} blocks, expected at most {}: each halves the picture",
               unet.encoder.size(), kMostResolutions);
  if (unet.encoder.size() != unet.decoder.size())
    fail_usage("network.unet.encoder has {} blocks and network.unet.decoder {}, expected as many of both",
               unet.encoder.size(), unet.decoder.size());
  for (const auto& block : unet.encoder) check_widths("unet.encoder", block, false);
  for (const auto& block : unet.decoder) check_widths("unet.decoder", block, false);
  check_widths("unet.bottleneck", unet.bottleneck, false);
  check_widths("unet.context", {unet.context}, false);
  check_use(config);
}

}  // namespace ld
