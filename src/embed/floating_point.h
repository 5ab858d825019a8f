// The floating-point settings of a thread: rounding, traps, flags, and whether denormals are flushed. They
// are the caller's; the library computes with its own.
#pragma once

#include <cfenv>

namespace ld {

/// Those of the calling thread when it is made.
class FloatingPointSettings {
 public:
  FloatingPointSettings() { std::fegetenv(&environment_); }
  const std::fenv_t* get() const { return &environment_; }

 private:
  std::fenv_t environment_{};
};

/// While it lives, the calling thread has the settings that a process starts with, or those given; then its
/// own again.
class FloatingPointGuard {
 public:
  FloatingPointGuard() { std::fesetenv(FE_DFL_ENV); }
  explicit FloatingPointGuard(const FloatingPointSettings& settings) { std::fesetenv(settings.get()); }
  ~FloatingPointGuard() { std::fesetenv(before_.get()); }
  FloatingPointGuard(const FloatingPointGuard&) = delete;
  FloatingPointGuard& operator=(const FloatingPointGuard&) = delete;

 private:
  const FloatingPointSettings before_;
};

}  // namespace ld
