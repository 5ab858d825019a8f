#include "models/unet.h"

#include "models/row_strips.h"
#include "ops/kernels/constants.h"

namespace ld {

using torch::Tensor;
namespace nn = torch::nn;

namespace {

int64_t even(int64_t n) {
  return (n + 1) / 2 * 2;
}

/// The block on `x`, whose memory is free as soon as the first layer has read it.
Tensor run(nn::Sequential& block, Tensor x) {
  for (auto& layer : *block) x = layer.forward<Tensor>(x);
  return x;
}

PictureSize halved(const PictureSize& size, int64_t times = 1) {
  return {size.batch, size.height >> times, size.width >> times};
}

int64_t picture_bytes(const PictureSize& size, int64_t channels) {
  return size.batch * channels * size.height * size.width * int64_t(sizeof(float));
}

}  // namespace

UNet::UNet(int64_t inputs, const UNetConfig& config) : config_(config), inputs_(inputs) {
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
  context_ = register_module("context", std::make_shared<Convolution>(channels, config.context));
}

nn::Sequential UNet::make_block(int64_t inputs, const std::vector<int64_t>& widths) const {
  nn::Sequential block;
  for (const int64_t width : widths) {
    block->push_back(std::make_shared<Convolution>(inputs, width));
    block->push_back(nn::LeakyReLU(nn::LeakyReLUOptions().negative_slope(kLeakySlope).inplace(true)));
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

PictureSize UNet::padded(const PictureSize& size) const {
  const int64_t multiple = int64_t(1) << encoder_.size();
  const auto up = [&](int64_t n) { return (n + multiple - 1) / multiple * multiple; };
  return {size.batch, up(size.height), up(size.width)};
}

/// The padded picture, with its channels last where no gradient is kept.
PictureRows UNet::padded(const PictureRows& input, const PictureSize& size) const {
  return [this, &input, size](int64_t begin, int64_t end) {
    const int64_t first = std::min(begin, size.height - 1), last = std::min(end, size.height),
                  right = padded(size).width - size.width;
    Tensor x = input(first, last);
    if (right + end - last > 0) x = at::replication_pad2d(x, {0, right, 0, end - last});
    x = rows(x, begin - first, end - first);
    return at::GradMode::is_enabled() ? x : x.contiguous(at::MemoryFormat::ChannelsLast);
  };
}

std::vector<Tensor> UNet::features(const Tensor& input, int64_t resolutions) {
  const PictureRows picture = [&](int64_t begin, int64_t end) { return rows(input, begin, end); };
  const Coarse coarse = encode(picture, {input.size(0), input.size(2), input.size(3)}, resolutions);
  std::vector<Tensor> features = coarse.features;
  const int64_t step = strip_rows(input.size(2), context_row_bytes(coarse.size), 2 * context_reach());
  features[0] = in_strips(input.size(2), step,
                          [&](int64_t begin, int64_t end) { return context(coarse, picture, begin, end); });
  return features;
}

UNet::Coarse UNet::encode(const PictureRows& input, PictureSize size, int64_t resolutions) {
  PictureSize here = padded(size);
  const int64_t blocks = int64_t(encoder_.size());
  Tensor x = encode_block(0, padded(input, size), here);
  std::vector<Tensor> skips;  // of resolutions 1, 2, ...
  for (size_t i = 1; i < encoder_.size(); ++i) {
    skips.push_back(x);
    here = halved(here);
    x = encode_block(
        i, [&](int64_t begin, int64_t end) { return rows(skips.back(), begin, end); }, here);
    strips_done(0.3 + 0.1 * double(i) / double(blocks));
  }
  x = run(bottleneck_, std::move(x));

  Coarse coarse{std::vector<Tensor>(static_cast<size_t>(resolutions)), {}, size};
  for (int64_t resolution = blocks; resolution > 0; --resolution) {
    const int64_t scale = int64_t(1) << resolution;
    if (resolution < resolutions)
      coarse.features[size_t(resolution)] = x.narrow(2, 0, (size.height + scale - 1) / scale)
                                                .narrow(3, 0, (size.width + scale - 1) / scale)
                                                .contiguous();
    if (resolution == 1) break;
    const auto block = size_t(blocks - resolution);
    const PictureSize finer = halved(padded(size), resolution - 1);
    const PictureRows skip = [&](int64_t begin, int64_t end) { return rows(skips.back(), begin, end); };
    const int64_t step = strip_rows(finer.height, decoder_row_bytes(block, finer), 2 * context_reach());
    x = in_strips(finer.height, step, [&](int64_t begin, int64_t end) {
      return decode_rows(block, x, skip, finer.height, begin, end);
    });
    skips.pop_back();
    strips_done(0.5 - 0.1 * double(resolution) / double(blocks));
  }
  coarse.half = x;
  return coarse;
}

Tensor UNet::context(const Coarse& coarse, const PictureRows& input, int64_t begin, int64_t end) {
  const Tensor x = decode_rows(decoder_.size() - 1, coarse.half, padded(input, coarse.size),
                               padded(coarse.size).height, begin, end);
  return x.narrow(3, 0, coarse.size.width).contiguous();
}

/// A block of the encoder and its pool.
Tensor UNet::encode_block(size_t block, const PictureRows& input, PictureSize size) {
  const std::vector<int64_t>& widths = config_.encoder[block];
  const int64_t halo = even(int64_t(widths.size()));
  const int64_t step =
      strip_rows(size.height, row_bytes(size, skip_channels(int64_t(block)), widths), 2 * halo);
  // Of a picture of half the height: a strip of rows leaves half as many.
  return in_strips(size.height / 2, (step + 1) / 2, [&](int64_t half_begin, int64_t half_end) {
    const int64_t begin = 2 * half_begin, end = 2 * half_end;
    const int64_t first = std::max<int64_t>(begin - halo, 0), last = std::min(end + halo, size.height);
    const Tensor x = run(encoder_[block], input(first, last));
    if (block == 0) strips_done(0.3 * double(end) / double(size.height));
    return at::max_pool2d(rows(x, begin - first, end - first), 2);
  });
}

/// Rows of a decoder block, the last one with the convolution to the context behind it; `height` is that of
/// the padded skip.
Tensor UNet::decode_rows(size_t block, const Tensor& coarse, const PictureRows& skip, int64_t height,
                         int64_t begin, int64_t end) {
  const bool finest = block + 1 == decoder_.size();
  const int64_t halo = even(int64_t(decoder_widths(block).size()));
  const int64_t first = std::max<int64_t>(begin / 2 * 2 - halo, 0), last = std::min(even(end) + halo, height);
  // One more coarse row on either side: what bilinear upsampling blends the outermost rows with.
  const int64_t coarse_first = std::max<int64_t>(first / 2 - 1, 0),
                coarse_last = std::min(last / 2 + 1, height / 2);
  Tensor x = rows(upsample(rows(coarse, coarse_first, coarse_last)), first - 2 * coarse_first,
                  last - 2 * coarse_first);
  x = at::cat({x, skip(first, last)}, 1);
  x = run(decoder_[block], std::move(x));
  if (finest) x = context_->forward(x);
  return rows(x, begin - first, end - first);
}

int64_t UNet::context_reach() const {
  size_t convolutions = 1;
  for (size_t block = 0; block < decoder_.size(); ++block)
    convolutions = std::max(convolutions, decoder_widths(block).size());
  return even(int64_t(convolutions));
}

std::vector<int64_t> UNet::decoder_widths(size_t block) const {
  std::vector<int64_t> widths = config_.decoder[block];
  if (block + 1 == decoder_.size()) widths.push_back(config_.context);
  return widths;
}

/// Channels of the skip of a resolution; of the coarsest one, what the bottleneck reads.
int64_t UNet::skip_channels(int64_t resolution) const {
  return resolution == 0 ? inputs_ : config_.encoder[size_t(resolution) - 1].back();
}

/// Memory of one row in a block: what comes in, once more while it is put together, and two layers' outputs.
int64_t UNet::row_bytes(const PictureSize& size, int64_t inputs, const std::vector<int64_t>& widths) const {
  const int64_t widest = *std::max_element(widths.begin(), widths.end());
  return size.batch * std::max(2 * inputs, inputs + 2 * widest) * size.width * context_->element_size();
}

int64_t UNet::decoder_row_bytes(size_t block, const PictureSize& size) const {
  const int64_t resolution = int64_t(decoder_.size() - 1 - block);
  return row_bytes(size, feature_channels(config_, resolution + 1) + skip_channels(resolution),
                   decoder_widths(block));
}

int64_t UNet::context_row_bytes(const PictureSize& size) const {
  return decoder_row_bytes(decoder_.size() - 1, padded(size));
}

int64_t UNet::encode_bytes(const PictureSize& size, int64_t resolutions) const {
  const PictureSize whole = padded(size);
  const int64_t blocks = int64_t(encoder_.size());
  const auto result = [&](int64_t resolution) {  // of a decoder block, or the bottleneck
    return picture_bytes(halved(whole, resolution), feature_channels(config_, resolution));
  };
  int64_t skips = 0, kept = 0;
  for (int64_t r = 1; r <= blocks; ++r) skips += picture_bytes(halved(whole, r), skip_channels(r));
  int64_t most = skips + 2 * result(blocks);
  for (int64_t r = blocks; r > 1; --r) {  // from resolution r to the finer one
    skips -= picture_bytes(halved(whole, r), skip_channels(r));
    if (r < resolutions) kept += result(r);
    most = std::max(most, skips + kept + result(r) + result(r - 1));
  }
  return most;
}

int64_t UNet::coarse_bytes(const PictureSize& size, int64_t resolutions) const {
  const PictureSize whole = padded(size);
  int64_t bytes = 0;
  for (int64_t r = 1; r < std::max<int64_t>(resolutions, 2); ++r)
    bytes +=
        picture_bytes(halved(whole, r), feature_channels(config_, r)) * (r == 1 && resolutions > 1 ? 2 : 1);
  return bytes;
}

}  // namespace ld
