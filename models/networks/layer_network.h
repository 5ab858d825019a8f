// The layered denoiser of [MH20] (figure 2, section 3, appendix A), network name "layer".
#pragma once

#include "models/kernel_generator.h"
#include "models/networks/layered_network.h"

namespace ld {

/// Each layer before and after its filter, to look at. Radiance is premultiplied: L_l / n_l is what the layer
/// adds to a picture in which nothing lies in front of it, its colour times its opacity; radiance / opacity
/// is the colour alone. With the weighted compositor n_l is w_l, the opacity 1 and the radiance the colour.
/// With demodulation, the layers are those of the radiance as it is.
struct LayerPictures {
  torch::Tensor unfiltered_radiance;  // L_l / n_l [B, N, 3, H, W]
  torch::Tensor radiance;             // filtered L_l over filtered n_l, eq. 4 [B, N, 3, H, W]
  torch::Tensor opacity;              // alpha_l, filtered w_l over filtered n_l, eq. 4 [B, N, 1, H, W]
  torch::Tensor
      weight;  // share of the layer's colour in the output [B, N, 1, H, W]; the sum over layers is 1

  friend std::vector<torch::Tensor*> tensors_of(LayerPictures& p) {
    return {&p.unfiltered_radiance, &p.radiance, &p.opacity, &p.weight};
  }
};

/// What the stages of the network hand on, for tests. Names as in [MH20].
struct LayerStages {
  torch::Tensor embedding;         // E_xys [B, S, E, H, W]
  torch::Tensor context;           // C_xy [B, C, H, W]
  torch::Tensor partition_logits;  // [B, S, N, H, W]
  Partition layers;                // eq. 1 and 2
  LayerPictures pictures;
  // eq. 5 or 6: without demodulation, the sum of weight * radiance / opacity [B, 3, H, W]
  torch::Tensor output;
};

class LayerNetwork : public LayeredNetwork {
 public:
  explicit LayerNetwork(const NetworkConfig& config);

  LayerStages stages(const NetworkInput& input);

  /// Of an input in strips.
  LayerPictures layers(const InputSource& input);

  /// The kernels that pixel (x, y) scatters its light with: exp(e_l) n_l / sum of it over layers and taps,
  /// [B, N, K*K]; all 0 for a pixel without samples.
  torch::Tensor kernels_at(const InputSource& input, int64_t x, int64_t y);

  int64_t memory_bytes(int64_t samples, int64_t height, int64_t width) const override;

 private:
  torch::Tensor denoise(const InputSource& input) override;
  Kernels make_kernels(const InputSource& input) override;
  template <class Use>
  auto in_layer_strips(const InputSource& input, const Use& use);
  LayerPictures looked_at(const Layers& layers, int64_t first_row) const;

  std::shared_ptr<KernelGenerator> kernel_generator_;
};

}  // namespace ld
