#include "frame/zeroed_floats.h"

#include <sys/mman.h>

namespace ld {

void* map_zeros(size_t bytes) {
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (memory == MAP_FAILED) return nullptr;
  madvise(memory, bytes, MADV_HUGEPAGE);  // where it cannot, small pages do
  return memory;
}

void unmap_zeros(void* memory, size_t bytes) {
  munmap(memory, bytes);
}

}  // namespace ld
