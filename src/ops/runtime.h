// LibTorch's process-wide settings, made once by every program.
#pragma once

#include <cfenv>
#include <vector>

namespace ld {

/// Sets the number of threads (LibTorch 1.13 starts with half the cores), flushes denormals in each of them
/// (fading activations would slow the arithmetic a hundredfold), takes large tensors from a pool, and warns
/// when the BLAS behind LibTorch is the slow reference one. May start the program again (ops/blas_kernels.h),
/// so call it before anything is written.
void configure_runtime(int threads);

/// The part of it that a library may do in somebody else's program: as many threads for the calling thread's
/// work and, while it lives, denormals flushed in all of them. Afterwards they treat denormals, and all else
/// that <cfenv> knows, as before. Of the calling thread that is certain; of LibTorch's pool it holds because
/// OpenMP gives the n-th piece of such work to the n-th thread both times. One guard at a time for each
/// calling thread, destroyed by it.
class RuntimeGuard {
 public:
  explicit RuntimeGuard(int threads);
  ~RuntimeGuard();
  RuntimeGuard(const RuntimeGuard&) = delete;
  RuntimeGuard& operator=(const RuntimeGuard&) = delete;

 private:
  int threads_, threads_before_;
  std::fenv_t caller_before_;
  std::vector<std::fenv_t> pool_before_;  // of each thread
};

}  // namespace ld
