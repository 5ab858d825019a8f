// The U-net of [MH20] figure 3: context features of each pixel from the averaged embeddings of its
// surroundings.
#pragma once

#include <torch/torch.h>

#include <functional>
#include <memory>
#include <vector>

#include "models/network_config.h"
#include "models/parameters.h"

namespace ld {

/// Rows [begin, end) of a picture, [B, C, end - begin, W]; asked for more than once and with overlaps.
using PictureRows = std::function<torch::Tensor(int64_t begin, int64_t end)>;

struct PictureSize {
  int64_t batch, height, width;
};

/// 3x3, zeros beyond the border. (LibTorch's own module would draw random weights that nobody uses, from its
/// global generator.) Parameters: weight [outputs, inputs, 3, 3], bias [outputs].
class Convolution : public torch::nn::Module {
 public:
  Convolution(int64_t inputs, int64_t outputs)
      : weight_(register_parameter("weight", new_parameter({outputs, inputs, 3, 3}))),
        bias_(register_parameter("bias", new_parameter({outputs}))) {}

  torch::Tensor forward(const torch::Tensor& x) {
    return at::conv2d(x, weight_, bias_, /*stride=*/1, /*padding=*/1);
  }

  int64_t element_size() const { return int64_t(weight_.element_size()); }

 private:
  torch::Tensor weight_, bias_;
};

/// Encoder blocks of 3x3 convolutions with leaky ReLU, a 2x2 max-pool after each; a bottleneck block; decoder
/// blocks, each on the result so far scaled up by 2 and concatenated with the skip of that resolution; a last
/// 3x3 convolution without activation. A skip is the pooled output of the encoder block whose resolution it
/// has, the finest one the U-net's own input. Pictures are padded to the multiple that the pools need by
/// repeating the last row and column, and cropped again; H and W from 1.
///
/// Without a gradient to keep, every block runs in strips of rows (models/row_strips.h), widened by the reach
/// of its convolutions, so that of each resolution but the full one only blocks' results exist as a whole: at
/// 1920x1080 half a gigabyte, where all of it would take 6. Tiles of the whole U-net would have to overlap by
/// its reach of 160 pixels. There the convolutions also have their channels last in memory, which makes them
/// 1.05 to 1.2 times as fast (oneDNN, AVX-512; a training step gains nothing): inference and training differ
/// by rounding.
class UNet : public torch::nn::Module {
 public:
  /// The configuration has as many decoder as encoder blocks, none of them empty (checked by make_network).
  UNet(int64_t inputs, const UNetConfig& config);

  /// [B, inputs, H, W] -> context features [B, context, H, W].
  torch::Tensor forward(const torch::Tensor& input) { return features(input, 1)[0]; }

  /// What the decoder knows at full resolution (the context), 1/2, 1/4, ...: the outputs of its blocks, and
  /// of the bottleneck as the coarsest one. Entry i is [B, feature_channels(i), ceil(H / 2^i), ceil(W /
  /// 2^i)].
  std::vector<torch::Tensor> features(const torch::Tensor& input, int64_t resolutions);

  /// All of that but full resolution, which context() makes for the rows that are wanted.
  struct Coarse {
    std::vector<torch::Tensor> features;  // as above; entry 0 is undefined
    torch::Tensor half;                   // what the last decoder block scales up; of the padded picture
    PictureSize size;
  };
  Coarse encode(const PictureRows& input, PictureSize size, int64_t resolutions);
  torch::Tensor context(const Coarse& coarse, const PictureRows& input, int64_t begin, int64_t end);

  /// Rows beyond a strip that context() reads of its input on either side, and what a row of it takes.
  int64_t context_reach() const;
  int64_t context_row_bytes(const PictureSize& size) const;

  /// Of encode(), for float32: the most that it needs at a time besides its strips, and what it leaves.
  int64_t encode_bytes(const PictureSize& size, int64_t resolutions) const;
  int64_t coarse_bytes(const PictureSize& size, int64_t resolutions) const;

  /// The channels of each of the config.resolutions() that features() has.
  static int64_t feature_channels(const UNetConfig& config, int64_t resolution);

 private:
  torch::nn::Sequential make_block(int64_t inputs, const std::vector<int64_t>& widths) const;
  torch::Tensor upsample(const torch::Tensor& x) const;
  PictureSize padded(const PictureSize& size) const;
  PictureRows padded(const PictureRows& input, const PictureSize& size) const;
  torch::Tensor encode_block(size_t block, const PictureRows& input, PictureSize size);
  torch::Tensor decode_rows(size_t block, const torch::Tensor& coarse, const PictureRows& skip,
                            int64_t height, int64_t begin, int64_t end);
  std::vector<int64_t> decoder_widths(size_t block) const;
  int64_t decoder_row_bytes(size_t block, const PictureSize& size) const;
  int64_t row_bytes(const PictureSize& size, int64_t inputs, const std::vector<int64_t>& widths) const;
  int64_t skip_channels(int64_t resolution) const;

  UNetConfig config_;
  int64_t inputs_;
  std::vector<torch::nn::Sequential> encoder_, decoder_;
  torch::nn::Sequential bottleneck_{nullptr};
  std::shared_ptr<Convolution> context_;
};

}  // namespace ld
