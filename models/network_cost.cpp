#include "models/network_cost.h"

#include <cmath>

#include "core/error.h"
#include "models/network.h"

namespace ld {
namespace {

bool starts_with(const std::string& text, const std::string& beginning) {
  return text.rfind(beginning, 0) == 0;
}

/// The number at the end of the word that `name` begins with: 3 of "decoder3.0.weight".
int64_t trailing_number(const std::string& name) {
  const std::string word = name.substr(0, name.find('.'));
  const size_t digits = word.find_last_not_of("0123456789") + 1;
  if (digits == word.size()) fail("cost of a network: module '{}' has no number, expected its level", word);
  return std::stoll(word.substr(digits));
}

/// How many times the picture's side is halved where a module of the U-net works.
int64_t unet_level(const std::string& name, int64_t levels) {
  if (starts_with(name, "encoder")) return trailing_number(name);
  if (starts_with(name, "bottleneck")) return levels;
  if (starts_with(name, "decoder")) return levels - 1 - trailing_number(name);
  if (starts_with(name, "context")) return 0;
  fail("cost of a network: the U-net has a module '{}' of unknown resolution", name);
}

int64_t round_up(int64_t value, int64_t multiple) {
  return (value + multiple - 1) / multiple * multiple;
}

/// What a network filters: one kernel for each source of each pixel.
struct Counts {
  double samples;   // that pass through the reducer
  double kernels;   // a pixel
  double channels;  // filtered with each, the sum of weights among them
};

Counts counts_of(const NetworkConfig& config, double spp) {
  const double layers = double(config.layers);
  // Radiance in one form or two and the sum of weights; alpha compositing filters a transmittance too.
  const double light = config.demodulation == "none" ? 3 : 6;
  const double channels = light + (config.compositing == "alpha" ? 2 : 1);
  switch (network_traits(config.name).sources) {
    case Sources::layers:
      return {spp, layers, channels};
    case Sources::samples:
      return {spp, spp, light + 1};
    case Sources::pixels:
      return {1, 1, light + 1};
  }
  fail("cost of a network: '{}' has sources of an unknown kind", config.name);
}

}  // namespace

NetworkCost multiply_adds(const NetworkConfig& config, int64_t spp, int64_t height, int64_t width) {
  const auto network = make_network_shapes(config);
  const Counts sources = counts_of(config, double(spp));
  const double pixels = double(height * width);
  const bool has_levels = network_traits(config.name).has_levels;
  // Pixels of the picture whose sides are halved `level` times.
  const auto pixels_at = [&](int64_t level) {
    const int64_t scale = int64_t(1) << level;
    const int64_t rows = (height + scale - 1) / scale, columns = (width + scale - 1) / scale;
    return double(rows * columns);
  };
  const auto levels = int64_t(config.unet.encoder.size());
  const double padded =
      double(round_up(height, int64_t(1) << levels) * round_up(width, int64_t(1) << levels));
  NetworkCost cost;
  for (const auto& entry : network->named_parameters()) {
    if (entry.value().dim() < 2) continue;  // biases
    const std::string& name = entry.key();
    const std::string inner = name.substr(name.find('.') + 1);
    const auto weights = double(entry.value().numel());
    if (starts_with(name, "unet.")) {
      cost.unet += weights * padded * std::pow(0.25, unet_level(inner, levels));
    } else if (starts_with(name, "sample_reducer.")) {
      cost.reducer += weights * pixels * sources.samples;
      if (starts_with(inner, "0.")) cost.first_layer = weights * pixels * sources.samples;
    } else if (starts_with(name, "sample_partitioner.")) {
      cost.partitioner += weights * pixels * sources.samples;
    } else if (starts_with(name, "modulation.")) {
      cost.filtering += weights * pixels;
    } else if (starts_with(name, "rejection.")) {
      cost.filtering += weights * pixels * sources.kernels;
    } else if (starts_with(name, "kernel_generator")) {
      const int64_t level = has_levels ? trailing_number(name) : 0;
      cost.kernel_generator += weights * pixels_at(level) * sources.kernels;
    } else if (network_traits(config.name).filter == Filter::own) {
      cost.filtering += weights * pixels;
    } else {
      fail("cost of a network: '{}' has a parameter '{}' of unknown use", config.name, name);
    }
  }
  const auto taps = double(config.kernel_size * config.kernel_size);
  for (int64_t level = 0; level < (has_levels ? config.levels : 1); ++level)
    cost.filtering += pixels_at(level) * sources.kernels * taps * sources.channels;
  return cost;
}

}  // namespace ld
