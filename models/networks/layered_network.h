// What the networks with layers share: samples to layers ([MH20] section 3, eq. 1 and 2).
#pragma once

#include <memory>
#include <vector>

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

  /// The layers of some rows.
  struct Layers {
    torch::Tensor context;  // C_xy
    Partition partition;
    torch::Tensor modulators;  // undefined without demodulation

    friend std::vector<torch::Tensor*> tensors_of(Layers& layers) {
      std::vector<torch::Tensor*> tensors = tensors_of(layers.partition);
      tensors.insert(tensors.end(), {&layers.context, &layers.modulators});
      return tensors;
    }
  };

  /// Partitioner and partition of rows [begin, end).
  Layers make_layers(const InputSource& input, const SampleEmbeddings& embeddings, const Context& context,
                     int64_t begin, int64_t end) const;

  /// The kernels of a whole picture's layers.
  Kernels kernels_of_layers(const InputSource& input, const KernelGenerator& generator) const;

  /// Memory of a row of layers, held from one strip to the next, and of a row of samples on the way there.
  int64_t layers_row_bytes(const PictureSize& size) const;

  Compositing compositing() const {
    return config().compositing == "weighted" ? Compositing::weighted : Compositing::alpha;
  }

  std::shared_ptr<SamplePartitioner> sample_partitioner_;
};

}  // namespace ld
