// The memory of all windows of a plan.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>

namespace ld {

/// Zeros that take no memory before they are written.
class Arena {
 public:
  explicit Arena(int64_t floats) {
    memory_.reset(static_cast<float*>(std::calloc(size_t(floats + kAligned), sizeof(float))));
    if (!memory_) throw std::bad_alloc();
  }
  float* begin() const {
    const auto address = reinterpret_cast<uintptr_t>(memory_.get());
    return memory_.get() + (kAligned - address / sizeof(float) % kAligned) % kAligned;
  }

  /// Floats up to where the next window may begin.
  static int64_t round_up(int64_t floats) { return (floats + kAligned - 1) / kAligned * kAligned; }

 private:
  static constexpr int64_t kAligned =
      32;  // floats: whole vectors of every instruction set, whole cache lines
  struct Free {
    void operator()(float* memory) const { std::free(memory); }
  };
  std::unique_ptr<float[], Free> memory_;
};

}  // namespace ld
