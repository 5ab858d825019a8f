// Small networks of every kind (small_config.h), and random input for any configuration.
#pragma once

#include "core/error.h"
#include "frame/schema.h"
#include "models/initialise.h"
#include "tests/models/small_config.h"
#include "tests/support/tensors.h"

namespace ld {

/// small_config() of every registered network that filters, also of the one that is added tomorrow: as [MH20]
/// has it, with demodulation, rejection and bounded kernels, and with weighted compositing of those that have
/// layers.
inline std::vector<NetworkConfig> every_config() {
  std::vector<NetworkConfig> configs;
  for (const std::string& name : networks_that_filter()) {
    NetworkConfig config = small_config();
    config.name = name;
    configs.push_back(config);
    NetworkConfig demodulating = config;
    demodulating.features = {"radiance", "specular", "depth", "albedo"};
    demodulating.demodulation = "albedo";
    demodulating.logit_bound = 4;
    demodulating.super_resolution.activation = "relu";
    demodulating.rejection = network_traits(name).filter == Filter::splat;
    if (network_traits(name).remembers) demodulating.features.emplace_back("flow");
    configs.push_back(demodulating);
    config.compositing = "weighted";
    try {
      make_network(config);
    } catch (const UsageError&) {
      continue;  // no layers
    }
    configs.push_back(config);
  }
  return configs;
}

/// These, and those that make the light themselves.
inline std::vector<NetworkConfig> every_network() {
  std::vector<NetworkConfig> configs = every_config();
  NetworkConfig recurrent = small_recurrent_config();
  recurrent.features.pop_back();  // emission, which few frames hold
  configs.push_back(recurrent);
  NetworkConfig forgetful = small_recurrent_config();
  forgetful.recurrence = false;
  forgetful.unet.upsampling = "bilinear";
  forgetful.features = {"depth", "normal", "albedo"};
  configs.push_back(forgetful);
  return configs;
}

/// What a failing test calls the network.
inline std::string title(const NetworkConfig& config) {
  return config.name + " " + config.compositing + ", " + std::to_string(config.layers) + " layers" +
         (config.demodulation == "none" ? "" : ", demodulating");
}

inline bool has_layers(const NetworkConfig& config) {
  return network_traits(config.name).sources == Sources::layers;
}

inline bool works_on_pixels(const NetworkConfig& config) {
  return network_traits(config.name).sources == Sources::pixels;
}

/// Whether what it makes is a weighted mean of the samples, whatever its weights.
inline bool averages(const std::string& network) {
  const NetworkTraits& traits = network_traits(network);
  return traits.upscaling == 1 && traits.filter != Filter::none;
}

/// every_config() of those.
inline std::vector<NetworkConfig> averaging_configs() {
  std::vector<NetworkConfig> configs;
  for (NetworkConfig& config : every_config())
    if (averages(config.name)) configs.push_back(std::move(config));
  return configs;
}

/// The names of all that do.
inline std::vector<std::string> averaging_networks() {
  std::vector<std::string> names;
  for (const std::string& name : network_names())
    if (averages(name)) names.push_back(name);
  return names;
}

/// Whether it may see radiance as exposed.
inline bool may_be_exposed(const NetworkConfig& config) {
  return network_traits(config.name).upscaling == 1;
}

inline bool generates_kernels(const NetworkConfig& config) {
  return network_traits(config.name).filter != Filter::own;
}

/// Samples of which about a quarter are masked, and a pixel without any.
inline NetworkInput random_input(const NetworkConfig& config, int64_t b, int64_t s, int64_t h, int64_t w,
                                 torch::ScalarType type, uint32_t seed = 1) {
  const torch::Tensor valid = random_valid(b, s, h, w, seed);
  const torch::Tensor radiance = random_uniform({b, s, 3, h, w}, seed + 1, 0, 4) * valid;
  const torch::Tensor features =
      random_normal({b, s, channel_count(config.features), h, w}, seed + 2) * valid;
  return {features.to(type), radiance.to(type), valid.to(type)};
}

/// The same reflectance everywhere, where the network divides by one: a constant picture is then constant
/// light, and what is sent from pixel to pixel is the radiance itself.
inline NetworkInput with_one_reflectance(NetworkInput input, const NetworkConfig& config) {
  if (config.demodulation == "none") return input;
  for (const char* name : {"albedo", "specular"})
    if (const int64_t first = first_channel(config.features, name); first >= 0)
      input.features.narrow(2, first, 3).fill_(0.4);
  return input;
}

inline NetworkInput to_type(const NetworkInput& input, torch::ScalarType type) {
  return {input.features.to(type), input.radiance.to(type), input.valid.to(type)};
}

/// The samples of the given indices, in that order.
inline NetworkInput select_samples(const NetworkInput& input, const std::vector<int64_t>& samples) {
  const torch::Tensor index = torch::tensor(samples);
  return {input.features.index_select(1, index), input.radiance.index_select(1, index),
          input.valid.index_select(1, index)};
}

/// Multiplies the last layers of partitioner and kernel generators, which make the logits.
inline void scale_logits(Network& network, double scale) {
  const torch::NoGradGuard no_gradient;
  const std::string last_partition = std::to_string(network.config().sample_partitioner.size()),
                    last_kernel = std::to_string(network.config().kernel_generator.size());
  for (auto& entry : network.named_parameters()) {
    const std::string& name = entry.key();
    const bool partition = name.rfind("sample_partitioner." + last_partition + ".", 0) == 0;
    const bool kernel =
        name.rfind("kernel_generator", 0) == 0 && name.find("." + last_kernel + ".") != std::string::npos;
    if (partition || kernel) entry.value().mul_(scale);
  }
}

/// Xavier weights, and biases that are not 0, in the wanted type. Those weights of rejection and history that
/// begin at 0 differ from it, or nobody would notice a wrong one.
inline std::shared_ptr<Network> small_network(const NetworkConfig& config, torch::ScalarType type,
                                              uint64_t seed = 1) {
  const auto network = make_network(config);
  initialise(*network, seed);
  network->to(type);
  const torch::NoGradGuard no_gradient;
  uint32_t index = 100;
  for (auto& parameter : network->parameters())
    if (parameter.dim() == 1) parameter.copy_(random_normal(parameter.sizes(), index++, 0.3));
  auto named = network->named_parameters();
  // Predicted colours within the range of the tone map, beyond which a gradient is one that pulls back.
  if (auto* weight = named.find("super_resolution.2.weight")) weight->mul_(0.15);
  if (auto* bias = named.find("super_resolution.2.bias")) bias->mul_(0.2).add_(0.6);
  if (auto* weight = named.find("rejection.weight.0.weight"))
    weight->copy_(random_normal(weight->sizes(), 99, 0.05));
  if (auto* weight = named.find("history.gate.1.weight"))
    weight->copy_(random_normal(weight->sizes(), 98, 0.3));
  return network;
}

}  // namespace ld
