// The layered denoiser of [MH20] (figure 2, section 3, appendix A), network name "layer".
#pragma once

#include <memory>

#include "models/kernel_generator.h"
#include "models/network.h"
#include "models/sample_partitioner.h"
#include "models/sample_reducer.h"
#include "models/unet.h"
#include "ops/partition.h"

namespace ld {

/// What the stages of the network hand on, for tests and pictures of the layers. Names as in [MH20].
struct LayerStages {
  torch::Tensor embedding;         // E_xys [B, S, E, H, W]
  torch::Tensor context;           // C_xy [B, C, H, W]
  torch::Tensor partition_logits;  // [B, S, N, H, W]
  Partition layers;                // eq. 1 and 2
  torch::Tensor radiance;          // filtered L_l over filtered n_l, eq. 4 [B, N, 3, H, W]
  torch::Tensor transmittance;     // 1 - alpha_l, eq. 4 [B, N, 1, H, W]
  torch::Tensor output;            // eq. 5 [B, 3, H, W]
};

class LayerNetwork : public Network {
 public:
  explicit LayerNetwork(const NetworkConfig& config);

  torch::Tensor forward(const NetworkInput& input) override { return run(input, nullptr); }

  LayerStages stages(const NetworkInput& input);

 private:
  torch::Tensor run(const NetworkInput& input, LayerStages* stages);
  torch::Tensor filter(const Partition& layers, const torch::Tensor& context) const;
  torch::Tensor filter_rows(const Partition& layers, const torch::Tensor& context, int64_t begin,
                            int64_t end) const;

  std::shared_ptr<SampleReducer> sample_reducer_;
  std::shared_ptr<UNet> unet_;
  std::shared_ptr<SamplePartitioner> sample_partitioner_;
  std::shared_ptr<KernelGenerator> kernel_generator_;
};

}  // namespace ld
