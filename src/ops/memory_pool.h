// Large tensors from memory that earlier ones gave back. The system's allocator returns them to the kernel,
// and taking them anew costs a page fault for every 4 kB: half the time of an operator that is bound by
// memory, a tenth of a training step.
#pragma once

#include <cstdint>

namespace ld {

/// From now on LibTorch's CPU tensors of 1 MB and more come from the pool, except under ComposedOperators,
/// which is LibTorch as it comes. The pool gives memory back to the system rather than let the process grow
/// beyond what its live tensors needed at their peak, plus an eighth.
void use_memory_pool();

/// Gives all that no tensor uses back to the system.
void release_memory_pool();

struct MemoryPoolState {
  int64_t live, pooled, peak_live;  // bytes
};
MemoryPoolState memory_pool_state();

}  // namespace ld
