// What a network's configuration must fulfil, for those who look at one without LibTorch.
#pragma once

#include <string>
#include <vector>

#include "models/network_config.h"

namespace ld {

/// What has a kernel of its own: layers of samples, samples, or pixels, of which mean and variance are read.
enum class Sources { layers, samples, pixels };

/// What a kernel does: weighs what its source sends, so that a source can be rejected, or what its pixel
/// receives. Networks without generated kernels do something of their own, with modules of names that the
/// others have not, which work once a pixel. Networks without a filter (none) make the light themselves: they
/// divide by the albedo in their own way and take no parts of the light.
enum class Filter { splat, gather, own, none };

/// What all that know networks from outside need to know of one: checks, costs, exports.
struct NetworkTraits {
  Sources sources;
  bool has_levels;  // works at several resolutions, with a kernel generator for each
  Filter filter;
  bool remembers = false;  // keeps a state from frame to frame of a sequence (models/network.h)
  bool in_powers = false;  // predicts fifth roots of light, in which its loss is taken (Network::compare())
  /// Sides of the picture over those of the light that it reads. Above 1 it has two stages, the first of
  /// which predicts colours: what it makes is no weighted mean of samples.
  int64_t upscaling = 1;
};

/// Throws UsageError for a name that is not in models/networks.def.
const NetworkTraits& network_traits(const std::string& name);

/// Throws UsageError for an unknown name or sizes that do not fit together, as make_network() does, without
/// making anything: a configuration may come from a damaged file.
void check_network(const NetworkConfig& config);

/// What make_network() (models/network.h) knows, in alphabetical order.
std::vector<std::string> network_names();

}  // namespace ld
