// What the kernels of a network look like over a batch: the sign of a training that goes well or has
// collapsed to kernels of one tap, or to the same kernel everywhere.
#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "models/network.h"
#include "training/distributed/process_group.h"

namespace ld {

/// Means over pixels and layers.
struct KernelStatistics {
  double entropy = 0;       // of a kernel's normalised taps, in nats: 0 for one tap, log(n) for n equal ones
  double centre_share = 0;  // of the tap that keeps a pixel as it is
  std::vector<double> layer_share;  // of what pixels send, front to back; none without layers
  /// Between pixels, of a tap's share, relative to its mean: 0 for one kernel everywhere.
  double deviation = 1;
};

/// Looks at the kernels for an input, without a gradient. The entropy is that of the taps within a layer or
/// sample, however much that layer or sample sends in all.
KernelStatistics kernel_statistics(Network& network, const NetworkInput& input);

/// Collective. `own` of each process counts by its share of the batch.
KernelStatistics mean_over_processes(const KernelStatistics& own, double share, ProcessGroup& group);

/// Adds the columns of metrics.csv.
void add_to_row(const KernelStatistics& statistics, std::map<std::string, double>& row);

using KernelProbe = std::function<KernelStatistics(Network&, const NetworkInput&)>;

}  // namespace ld
