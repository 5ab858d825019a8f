// How many threads to use, and a parallel loop for code without LibTorch.
#pragma once

#include <cstdint>
#include <functional>

namespace ld {

/// OMP_NUM_THREADS if set, else the CPUs of this process's affinity mask (LibTorch 1.13 starts with half of
/// them). Throws UsageError when OMP_NUM_THREADS is not a positive number.
int default_threads();

/// Calls body(i) for i in [0, count), in any order, on up to `threads` threads. Indices are handed out one at
/// a time, so uneven work balances. The first exception stops the loop and is thrown again here.
void parallel_for(int64_t count, int threads, const std::function<void(int64_t)>& body);

}  // namespace ld
