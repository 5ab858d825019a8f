// How much memory a piece of work needs at its worst.
#pragma once

#include <functional>

namespace ld {

/// Runs `work` once and returns by how many MB (10^6 bytes) the resident memory of this process rose above
/// what it was before, at its highest: Linux's high-water mark, set back through /proc/self/clear_refs. Freed
/// memory that the allocator holds back is given to the system first. Throws Error where /proc does not allow
/// it.
double peak_memory_mb(const std::function<void()>& work);

}  // namespace ld
