// How many threads to use, and a parallel loop for code without LibTorch.
#pragma once

#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace ld {

/// OMP_NUM_THREADS if set, else the CPUs of this process's affinity mask (LibTorch 1.13 starts with half of
/// them). Throws UsageError when OMP_NUM_THREADS is not a positive number.
int default_threads();

/// Starts `count` threads that do the work. When the system refuses one, calls stop(), which must make the
/// work of the others end, waits for them and throws Error: a thread that nobody waits for would end the
/// process.
std::vector<std::thread> start_threads(int count, const std::function<void()>& work,
                                       const std::function<void()>& stop);

/// Calls body(i) for i in [0, count), in any order, on up to `threads` threads. Indices are handed out one at
/// a time, so uneven work balances. The first exception stops the loop and is thrown again here; an Error
/// when a thread cannot be started.
void parallel_for(int64_t count, int threads, const std::function<void(int64_t)>& body);

}  // namespace ld
