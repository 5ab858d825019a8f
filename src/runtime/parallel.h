// Work shared out over the threads of OpenMP, whose pool LibTorch and oneDNN use as well.
#pragma once

#include <omp.h>

#include <algorithm>
#include <cstdint>

namespace ld {

/// body(i, thread) for i in [0, count), thread in [0, threads), begun in that order, so that one may wait for
/// those before. The body throws nothing.
template <class Body>
void parallel_for(int threads, int64_t count, const Body& body) {
  const int used = int(std::min<int64_t>(threads, count));
  if (used <= 1) {
    for (int64_t i = 0; i < count; ++i) body(i, 0);
    return;
  }
#pragma omp parallel for num_threads(used) schedule(monotonic : dynamic)
  for (int64_t i = 0; i < count; ++i) body(i, omp_get_thread_num());
}

/// body(row, first pixel, pixels, thread) for rows [begin, end) in stretches of at most `most` pixels.
template <class Body>
void for_each_stretch(int threads, int64_t begin, int64_t end, int64_t width, int64_t most,
                      const Body& body) {
  const int64_t parts = (width + most - 1) / most;
  parallel_for(threads, (end - begin) * parts, [&](int64_t i, int thread) {
    const int64_t x = i % parts * most;
    body(begin + i / parts, x, std::min(most, width - x), thread);
  });
}

}  // namespace ld
