// What the kernels of a network look like over a batch: the sign of a training that goes well or has
// collapsed to kernels of one tap, or to the same kernel everywhere.
#pragma once

#include <functional>
#include <vector>

#include "models/network.h"

namespace ld {

/// Means over pixels and layers.
struct KernelStatistics {
  double entropy = 0;       // of a kernel's normalised taps, in nats: 0 for one tap, log(n) for n equal ones
  double centre_share = 0;  // of the tap that keeps a pixel as it is
  std::vector<double> layer_share;  // of what pixels send, front to back; none without layers
  double deviation =
      1;  // between pixels, of a tap's share, relative to its mean: 0 for one kernel everywhere
};

/// Of the kernels for an input, without a gradient. The entropy is that of the taps of a layer or sample, its
/// own share in the pixel apart.
KernelStatistics kernel_statistics(Network& network, const NetworkInput& input);

using KernelProbe = std::function<KernelStatistics(Network&, const NetworkInput&)>;

}  // namespace ld
