// Super-resolution and denoiser in two stages (models/networks/espcn_kpcn_network.cpp) as plain loops in
// double, and what they share with other networks.
#pragma once

#include "tests/support/scalar_networks.h"

namespace ld::reference {

/// 1 for pixels that have a valid sample, [B, 1, 1, H, W].
Grid drawn(const Grid& valid);

/// c x / (c + |x|) of the first `taps` channels.
Grid bounded(Grid logits, const NetworkLayout& layout);

/// A softmax over the pixels in reach that are `given`.
Grid gather(const Grid& logits, const Grid& values, const Grid& given);

/// The picture [B, 1, 3, H, W].
Grid espcn_kpcn(const Samples& samples, const Parameters& parameters, const NetworkLayout& layout);

}  // namespace ld::reference
