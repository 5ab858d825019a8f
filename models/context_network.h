// The first half of [MH20] figure 2, which all networks share: sample reducer, mean, U-net.
#pragma once

#include <memory>

#include "frame/schema.h"
#include "models/network.h"
#include "models/sample_embeddings.h"
#include "models/unet.h"

namespace ld {

class ContextNetwork : public Network {
 protected:
  /// `inputs` are the channels that the sample reducer reads.
  ContextNetwork(const NetworkConfig& config, int64_t inputs)
      : Network(config),
        sample_reducer_(register_module("sample_reducer", std::make_shared<SampleReducer>(config, inputs))),
        unet_(register_module("unet", std::make_shared<UNet>(config.sample_reducer.back(), config.unet))) {}

  std::shared_ptr<SampleReducer> sample_reducer_;
  std::shared_ptr<UNet> unet_;
};

}  // namespace ld
