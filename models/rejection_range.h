// The bound of rejection (models/rejection.h), for those that do without LibTorch.
#pragma once

namespace ld {

constexpr double kMostRejected = 16;  // a pixel's layer counts for e^-16, 1e-7, of another's at least

}  // namespace ld
