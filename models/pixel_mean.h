// What is left of an input where only the means of the pixels are known, as in pictures that renderers write.
#pragma once

#include "models/network_config.h"
#include "models/network_input.h"

namespace ld {

/// One sample a pixel: the mean of the radiance and of the encoded features of the samples that count. The
/// feature "radiance" is that of the mean, tone mapped after averaging, so that N samples and a picture of
/// their mean give one result. (A depth encoded before it is averaged differs from the encoded mean where
/// surfaces of different depths meet in a pixel.)
NetworkInput pixel_mean(NetworkInput input, const NetworkConfig& config);

}  // namespace ld
