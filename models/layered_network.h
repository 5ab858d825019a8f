// What the networks with layers share: samples to layers ([MH20] section 3, eq. 1 and 2).
#pragma once

#include <memory>
#include <vector>

#include "models/context_network.h"
#include "models/sample_partitioner.h"
#include "ops/partition.h"

namespace ld {

class LayeredNetwork : public ContextNetwork {
 protected:
  explicit LayeredNetwork(const NetworkConfig& config)
      : ContextNetwork(config, channel_count(config.features)),
        sample_partitioner_(
            register_module("sample_partitioner", std::make_shared<SamplePartitioner>(config))) {}

  struct Layers {
    std::vector<torch::Tensor> context;  // UNet::features, finest first
    Partition partition;
  };

  /// Reducer, U-net, partitioner and partition. The samples are not needed any more afterwards.
  Layers make_layers(NetworkInput input, int64_t resolutions) const;

  Compositing compositing() const {
    return config().compositing == "weighted" ? Compositing::weighted : Compositing::alpha;
  }

  std::shared_ptr<SamplePartitioner> sample_partitioner_;
};

}  // namespace ld
