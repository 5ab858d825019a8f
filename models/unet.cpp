#include "models/unet.h"

#include "models/row_strips.h"

namespace ld {

using torch::Tensor;
namespace nn = torch::nn;

namespace {

nn::Conv2d convolution(int64_t inputs, int64_t outputs) {
  return nn::Conv2d(nn::Conv2dOptions(inputs, outputs, 3).padding(1));
}

int64_t even(int64_t n) {
  return (n + 1) / 2 * 2;
}

/// Memory of one row of full resolution in a block: what comes in and two layers' outputs.
int64_t row_bytes(const Tensor& picture, int64_t inputs, const std::vector<int64_t>& widths) {
  const int64_t widest = *std::max_element(widths.begin(), widths.end());
  return picture.size(0) * (inputs + 2 * widest) * picture.size(3) * int64_t(picture.element_size());
}

}  // namespace

UNet::UNet(int64_t inputs, const UNetConfig& config) : config_(config) {
  std::vector<int64_t> skips;  // channels of the skips, finest first
  int64_t channels = inputs;
  for (const auto& widths : config.encoder) {
    skips.push_back(channels);
    encoder_.push_back(
        register_module("encoder" + std::to_string(encoder_.size()), make_block(channels, widths)));
    channels = widths.back();
  }
  bottleneck_ = register_module("bottleneck", make_block(channels, config.bottleneck));
  channels = config.bottleneck.back();
  for (const auto& widths : config.decoder) {
    const std::string name = "decoder" + std::to_string(decoder_.size());
    decoder_.push_back(register_module(name, make_block(channels + skips.back(), widths)));
    channels = widths.back();
    skips.pop_back();
  }
  context_ = register_module("context", convolution(channels, config.context));
}

nn::Sequential UNet::make_block(int64_t inputs, const std::vector<int64_t>& widths) const {
  nn::Sequential block;
  for (const int64_t width : widths) {
    block->push_back(convolution(inputs, width));
    block->push_back(nn::LeakyReLU(nn::LeakyReLUOptions().negative_slope(0.01).inplace(true)));
    inputs = width;
  }
  return block;
}

int64_t UNet::feature_channels(const UNetConfig& config, int64_t resolution) {
  if (resolution == 0) return config.context;
  const int64_t blocks = int64_t(config.decoder.size());
  return resolution == blocks ? config.bottleneck.back()
                              : config.decoder[size_t(blocks - 1 - resolution)].back();
}

Tensor UNet::upsample(const Tensor& x) const {
  const std::vector<int64_t> size = {2 * x.size(2), 2 * x.size(3)};
  return config_.upsampling == "bilinear" ? at::upsample_bilinear2d(x, size, /*align_corners=*/false)
                                          : at::upsample_nearest2d(x, size);
}

std::vector<Tensor> UNet::features(const Tensor& input, int64_t resolutions) {
  const int64_t height = input.size(2), width = input.size(3), multiple = int64_t(1) << encoder_.size();
  const int64_t bottom = (multiple - height % multiple) % multiple,
                right = (multiple - width % multiple) % multiple;
  Tensor x = bottom + right == 0 ? input : at::replication_pad2d(input, {0, right, 0, bottom});
  if (!at::GradMode::is_enabled()) x = x.contiguous(at::MemoryFormat::ChannelsLast);

  std::vector<Tensor> skips = {x};
  x = encode_finest(x);
  for (size_t i = 1; i < encoder_.size(); ++i) {
    skips.push_back(x);
    x = at::max_pool2d(encoder_[i]->forward(x), 2);
  }
  x = bottleneck_->forward(x);

  std::vector<Tensor> features(static_cast<size_t>(resolutions));
  for (int64_t resolution = int64_t(decoder_.size()); resolution > 0; --resolution) {
    const int64_t scale = int64_t(1) << resolution;
    if (resolution < resolutions)
      features[size_t(resolution)] =
          x.narrow(2, 0, (height + scale - 1) / scale).narrow(3, 0, (width + scale - 1) / scale).contiguous();
    if (resolution == 1) break;
    x = decoder_[decoder_.size() - size_t(resolution)]->forward(at::cat({upsample(x), skips.back()}, 1));
    skips.pop_back();
  }
  features[0] = decode_finest(x, skips.back(), height, width);
  return features;
}

/// The first encoder block and its pool.
Tensor UNet::encode_finest(const Tensor& input) {
  const int64_t height = input.size(2), halo = even(int64_t(config_.encoder[0].size()));
  const int64_t step = strip_rows(height, row_bytes(input, input.size(1), config_.encoder[0]));
  // Of a picture of half the height: a strip of fine rows leaves half as many.
  return in_strips(height / 2, step / 2, [&](int64_t half_begin, int64_t half_end) {
    const int64_t begin = 2 * half_begin, end = 2 * half_end;
    const int64_t first = std::max<int64_t>(begin - halo, 0), last = std::min(end + halo, height);
    const Tensor x = encoder_[0]->forward(rows(input, first, last));
    return std::vector<Tensor>{at::max_pool2d(rows(x, begin - first, end - first), 2)};
  })[0];
}

/// The last decoder block and the convolution to the context, of the padded picture's first rows and columns.
Tensor UNet::decode_finest(const Tensor& coarse, const Tensor& skip, int64_t height, int64_t width) {
  const int64_t padded = skip.size(2), halo = even(int64_t(config_.decoder.back().size()) + 1);
  std::vector<int64_t> widths = config_.decoder.back();
  widths.push_back(config_.context);
  const int64_t step = strip_rows(height, row_bytes(skip, coarse.size(1) + skip.size(1), widths));
  return in_strips(height, step, [&](int64_t begin, int64_t end) {
    const int64_t first = std::max<int64_t>(begin - halo, 0), last = std::min(even(end) + halo, padded);
    // One more coarse row on either side: what bilinear upsampling blends the outermost rows with.
    const int64_t coarse_first = std::max<int64_t>(first / 2 - 1, 0),
                  coarse_last = std::min(last / 2 + 1, padded / 2);
    const Tensor up = rows(upsample(rows(coarse, coarse_first, coarse_last)), first - 2 * coarse_first,
                           last - 2 * coarse_first);
    const Tensor x = decoder_.back()->forward(at::cat({up, rows(skip, first, last)}, 1));
    return std::vector<Tensor>{
        rows(context_->forward(x), begin - first, end - first).narrow(3, 0, width).contiguous()};
  })[0];
}

}  // namespace ld
