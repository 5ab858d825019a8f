// The first half of [MH20] figure 2, which all networks share: sample reducer, mean, U-net.
#pragma once

#include <memory>

#include "frame/schema.h"
#include "models/demodulation.h"
#include "models/network.h"
#include "models/rejection.h"
#include "models/sample_reducer.h"
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

  /// log n of what is sent, [B, N, H, W], less what is rejected.
  torch::Tensor weighed(const torch::Tensor& log_n, const torch::Tensor& embedding,
                        const torch::Tensor& context) const {
    return rejection_ ? rejection_->weighed(log_n, embedding, context) : log_n;
  }

  /// The picture [B, 3, H, W] from what was filtered: all forms of radiance that the input has, [B, C, H, W].
  torch::Tensor modulated(const torch::Tensor& filtered, const NetworkInput& input,
                          const torch::Tensor& context) const {
    if (!modulation_) return filtered;
    return Modulation::apply(filtered,
                             modulation_->factors(modulators(input.demodulator, input.valid), context));
  }

  std::shared_ptr<SampleReducer> sample_reducer_;
  std::shared_ptr<UNet> unet_;
  std::shared_ptr<Modulation> modulation_;  // null without demodulation
  std::shared_ptr<Rejection> rejection_;    // null without rejection
};

}  // namespace ld
