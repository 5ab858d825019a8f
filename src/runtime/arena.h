// The memory of all windows of a plan.
#pragma once

#include <cstdint>
#include <vector>

#include "frame/frame.h"

namespace ld {

/// Zeros that take no memory before they are written. In large pages, because the planes of one tile of
/// pixels lie in more small ones than a processor keeps the addresses of.
class Arena {
 public:
  explicit Arena(int64_t floats) : memory_(size_t(floats + kAligned)) {}
  float* begin() {
    const auto address = reinterpret_cast<uintptr_t>(memory_.data());
    return memory_.data() + (kAligned - address / sizeof(float) % kAligned) % kAligned;
  }

  /// Floats up to where the next window may begin.
  static int64_t round_up(int64_t floats) { return (floats + kAligned - 1) / kAligned * kAligned; }

 private:
  static constexpr int64_t kAligned =
      32;  // floats: whole vectors of every instruction set, whole cache lines
  std::vector<float, ZeroPages<float>> memory_;
};

}  // namespace ld
