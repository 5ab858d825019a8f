// The recurrent denoising autoencoder: Chaitanya et al. 2017, "Interactive Reconstruction of Monte Carlo
// Image Sequences using a Recurrent Denoising Autoencoder", figures 2 and 4.
#pragma once

#include <torch/torch.h>

#include <memory>
#include <string>
#include <vector>

#include "models/network.h"
#include "models/unet.h"

namespace ld {

/// What a network sees of a frame, and what brings its picture back. All means are over the valid samples of
/// a pixel. C is the radiance, A = albedo + specular, E what the first hit emits itself: the radiance of a
/// sample whose ray escaped (encoded depth 1), else the feature "emission" where the network reads it. With
/// A1 = max(A, 1e-3), 1 in a pixel without samples,
///   light S = max(C - E - E / 2048, 0) / A1,   picture = S A1 + E.
/// On a lamp C and E are equal but for their rounding, which the power 0.2 would make as large as light.
/// Data, and nothing that the network makes, is taken to the power 0.2, whose slope at 0 is infinite; so no
/// gradient goes through here.
struct RecurrentInput {
  torch::Tensor seen;  // [B, 7, H, W]: S^0.2, normal x and y (view space), d / (d + scale), roughness; zeros
                       // for features that the network does not read
  torch::Tensor texture;   // [B, 3, H, W] A1^0.2
  torch::Tensor emission;  // [B, 3, H, W] E

  RecurrentInput(const NetworkInput& input, const NetworkConfig& config);

  /// Of radiance [B, 3, H, W], S^0.2.
  torch::Tensor root(const torch::Tensor& radiance) const;
  /// The picture of a prediction of S^0.2, in which what is below 0 counts as 0. Finite for every finite one.
  torch::Tensor picture(const torch::Tensor& predicted) const;
};

/// 3x3 convolutions, a leaky ReLU of slope 0.1 after each. Parameters <place>.weight and .bias.
class LeakyConvolutions : public torch::nn::Module {
 public:
  LeakyConvolutions(int64_t inputs, const std::vector<int64_t>& widths);
  torch::Tensor forward(torch::Tensor x) const;

 private:
  std::vector<std::shared_ptr<Convolution>> convolutions_;
};

/// h_t = O_t = C(C(C(I_t) ^ h_(t-1))), ^ the concatenation of channels, C a 3x3 convolution with its leaky
/// ReLU (section 4.2). All have as many channels as the input I. The state enters within +-65504.
class RecurrentBlock : public torch::nn::Module {
 public:
  explicit RecurrentBlock(int64_t width);
  /// [B, width, H, W] both; `before` is undefined where nothing comes before, which is as zeros.
  torch::Tensor forward(const torch::Tensor& input, const torch::Tensor& before) const;

 private:
  std::shared_ptr<LeakyConvolutions> input_, joint_;
};

/// An encoder whose every resolution ends in a recurrent block, then a 2x2 max-pool; a decoder with skips
/// from before the pools; a last convolution without activation. Widths are those of NetworkConfig::unet:
/// blocks of the encoder, the bottleneck, blocks of the decoder, each after upsampling and on the
/// concatenation of the result so far with its skip. Pictures are padded to the multiple that the pools need
/// by repeating the last row and column, and cropped again; H and W from 1.
///
/// The table of figure 4 has 36 convolutions and, with 7 inputs, 1,951,935 parameters. (The paper's text says
/// 3.2 million, which no reading of the table gives.)
class RecurrentAutoencoder : public torch::nn::Module {
 public:
  explicit RecurrentAutoencoder(const NetworkConfig& config);

  /// [B, 7, H, W] -> [B, 3, H, W]. `state` has "h0", "h1", ... of the padded picture at full resolution, 1/2,
  /// ...; without network.recurrence it is ignored and left alone. Throws Error for one that does not fit.
  torch::Tensor forward(const torch::Tensor& seen, NetworkState& state) const;

 private:
  torch::Tensor remembered(size_t level, const torch::Tensor& x, NetworkState& state) const;

  bool recurrence_, bilinear_;
  std::vector<std::shared_ptr<LeakyConvolutions>> encoder_, decoder_;  // the bottleneck is the encoder's last
  std::vector<std::shared_ptr<RecurrentBlock>> recurrent_;
  std::shared_ptr<Convolution> output_;
};

/// What the network sees of a pixel.
inline constexpr int64_t kRecurrentInputs = 7;

}  // namespace ld
