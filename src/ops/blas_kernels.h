// Which of its kernels OpenBLAS runs. It chooses when it is loaded, by the processor's model number; a
// release older than the processor does not know it and may fall back to the kernels of 2004 ("Prescott":
// 0.3.21, which Debian 12 has, on a Xeon of 2023), five times slower than what the processor can do.
#pragma once

#include <string>

namespace ld {

/// OpenBLAS's name of the kernels in use ("Haswell", "SkylakeX", ...); empty when the BLAS is another one.
std::string blas_kernels();

/// The kernels to ask for instead of `kernels` on a processor with these instruction sets (the AVX-512 of
/// Skylake-X: F, CD, BW, DQ, VL); empty when `kernels` is as good or not one of OpenBLAS's for x86.
std::string better_blas_kernels(const std::string& kernels, bool avx2, bool avx512);

/// The same of this process and processor; empty when OPENBLAS_CORETYPE is set: somebody has chosen.
std::string better_blas_kernels();

/// Starts this program again, once and with its arguments, with OPENBLAS_CORETYPE naming better kernels, when
/// there are any and the variable is not set. Call before anything is written. Returns otherwise.
void choose_blas_kernels();

}  // namespace ld
