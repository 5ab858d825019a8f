// What the networks with layers share: samples to layers ([MH20] section 3, eq. 1 and 2).
#pragma once

#include <memory>

#include "models/kernel_generator.h"
#include "models/networks/context_network.h"
#include "models/sample_partitioner.h"
#include "ops/partition.h"

namespace ld {

class LayeredNetwork : public ContextNetwork {
 protected:
  explicit LayeredNetwork(const NetworkConfig& config)
      : ContextNetwork(config, channel_count(config.features)),
        sample_partitioner_(
            register_module("sample_partitioner", std::make_shared<SamplePartitioner>(config))) {}

  /// Partitioner and partition, from E_xys and C_xy.
  Partition make_layers(const NetworkInput& input, const torch::Tensor& embedding,
                        const torch::Tensor& context) const;

  /// The kernels of the layers of full resolution.
  Kernels kernels_of_layers(const NetworkInput& input, const KernelGenerator& generator) const;

  Compositing compositing() const {
    return config().compositing == "weighted" ? Compositing::weighted : Compositing::alpha;
  }

  std::shared_ptr<SamplePartitioner> sample_partitioner_;
};

}  // namespace ld
