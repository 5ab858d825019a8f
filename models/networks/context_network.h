// The first half of [MH20] figure 2, which all networks share: sample reducer, mean, U-net.
#pragma once

#include <memory>

#include "frame/schema.h"
#include "models/demodulation.h"
#include "models/network.h"
#include "models/rejection.h"
#include "models/sample_embeddings.h"
#include "models/unet.h"

namespace ld {

class ContextNetwork : public Network {
 protected:
  /// `inputs` are the channels that the sample reducer reads.
  ContextNetwork(const NetworkConfig& config, int64_t inputs)
      : Network(config),
        sample_reducer_(register_module("sample_reducer", std::make_shared<SampleReducer>(config, inputs))),
        unet_(register_module("unet", std::make_shared<UNet>(config.sample_reducer.back(), config.unet))) {
    if (config.demodulation != "none")
      modulation_ = register_module("modulation", std::make_shared<Modulation>(config));
    if (config.rejection) rejection_ = register_module("rejection", std::make_shared<Rejection>(config));
  }

  /// What the U-net knows of a picture, its full resolution on demand.
  struct Context {
    PictureRows picture;  // the U-net's input
    UNet::Coarse coarse;
  };
  Context make_context(const PictureRows& picture, const InputSource& input, int64_t resolutions) const {
    const InputSource::Sizes sizes = input.sizes();
    const PictureSize size = {sizes.batch, sizes.height, sizes.width};
    Context context = {kept_rows(picture, sizes.height, picture_bytes(size)), {}};
    context.coarse = unet_->encode(context.picture, size, resolutions);
    return context;
  }

  /// C_xy of rows [begin, end).
  torch::Tensor context_rows(const Context& context, int64_t begin, int64_t end) const {
    return unet_->context(context.coarse, context.picture, begin, end);
  }

  /// The forms of radiance that are filtered have so many channels together.
  int64_t radiance_channels() const { return modulation_ ? 6 : 3; }

  /// Rows beyond its own that a strip of the second half reads.
  int64_t filter_reach() const {
    return std::max(config().kernel_size / 2, modulation_ ? Modulation::kReach : 0);
  }

  /// What modulated() needs of some rows; undefined without demodulation.
  torch::Tensor modulators_of(const NetworkInput& strip) const {
    return modulation_ ? modulators(strip.demodulator, strip.valid) : torch::Tensor();
  }

  /// log n of what is sent, [B, N, H, W], less what is rejected.
  torch::Tensor weighed(const torch::Tensor& log_n, const torch::Tensor& embedding,
                        const torch::Tensor& context) const {
    return rejection_ ? rejection_->weighed(log_n, embedding, context) : log_n;
  }

  /// The picture [B, 3, H, W] from what was filtered, [B, radiance_channels(), H, W].
  torch::Tensor modulated(const torch::Tensor& filtered, const torch::Tensor& modulators,
                          const torch::Tensor& context) const {
    return modulation_ ? Modulation::apply(filtered, modulation_->factors(modulators, context)) : filtered;
  }

  /// Rows of a strip of the second half when each of them takes `row_bytes` besides what context_rows()
  /// does, and a kernel is applied.
  int64_t second_half_reach() const { return 2 * unet_->context_reach() + 2 * filter_reach(); }
  int64_t second_half_rows(const PictureSize& size, int64_t row_bytes) const {
    return strip_rows(size.height, unet_->context_row_bytes(size) + row_bytes, second_half_reach());
  }

  /// memory_bytes() of a network whose second half runs in such strips, beside `whole` bytes.
  int64_t memory_of(const PictureSize& size, int64_t resolutions, int64_t row_bytes, int64_t whole) const {
    const torch::NoGradGuard in_strips_only;
    const int64_t picture = picture_bytes(size);
    const int64_t kept = keeps_rows(picture) ? picture : 0, strip = StripBytes::current();
    const int64_t row = unet_->context_row_bytes(size) + row_bytes;
    const int64_t last_strips = (second_half_rows(size, row_bytes) + second_half_reach()) * row;
    return kept + std::max(unet_->encode_bytes(size, resolutions) + std::max(strip, last_strips),
                           unet_->coarse_bytes(size, resolutions) + whole + last_strips);
  }

  int64_t picture_bytes(const PictureSize& size) const {
    return size.batch * config().sample_reducer.back() * size.height * size.width * int64_t(sizeof(float));
  }

  std::shared_ptr<SampleReducer> sample_reducer_;
  std::shared_ptr<UNet> unet_;
  std::shared_ptr<Modulation> modulation_;  // null without demodulation
  std::shared_ptr<Rejection> rejection_;    // null without rejection
};

}  // namespace ld
