// LibTorch's process-wide settings, made once by every program.
#pragma once

namespace ld {

/// Sets the number of threads (LibTorch 1.13 starts with half the cores), flushes denormals in each of them
/// (fading activations would slow the arithmetic a hundredfold), takes large tensors from a pool, and warns
/// when the BLAS behind LibTorch is the slow reference one. May start the program again (ops/blas_kernels.h),
/// so call it before anything is written.
void configure_runtime(int threads);

/// The part of it that a library may do in somebody else's program: as many threads for the calling thread's
/// work and, while it lives, denormals flushed in all of them.
class RuntimeGuard {
 public:
  explicit RuntimeGuard(int threads);
  ~RuntimeGuard();
  RuntimeGuard(const RuntimeGuard&) = delete;
  RuntimeGuard& operator=(const RuntimeGuard&) = delete;

 private:
  int threads_, threads_before_;
};

}  // namespace ld
