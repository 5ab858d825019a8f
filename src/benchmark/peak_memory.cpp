#include "benchmark/peak_memory.h"

#include <malloc.h>

#include <algorithm>

#include "core/process/process_memory.h"
#include "ops/memory_pool.h"

namespace ld {

double peak_memory_mb(const std::function<void()>& work) {
  release_memory_pool();
  malloc_trim(0);
  reset_peak_resident();
  const int64_t before = resident_bytes();
  work();
  return static_cast<double>(std::max<int64_t>(peak_resident_bytes() - before, 0)) / 1e6;
}

}  // namespace ld
