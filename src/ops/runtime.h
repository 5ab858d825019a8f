// LibTorch's process-wide settings, made once by every program.
#pragma once

namespace ld {

/// Sets the number of threads (LibTorch 1.13 starts with half the cores), flushes denormals in each of them
/// (fading activations would slow the arithmetic a hundredfold), takes large tensors from a pool, and warns
/// when the BLAS behind LibTorch is the slow reference one. May start the program again (ops/blas_kernels.h),
/// so call it before anything is written.
void configure_runtime(int threads);

}  // namespace ld
