// Numbers that are none, in double.
#pragma once

#include <limits>

namespace ld {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinite = std::numeric_limits<double>::infinity();

}  // namespace ld
