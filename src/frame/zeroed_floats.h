// Large arrays of zeros.
#pragma once

#include <cstddef>
#include <new>
#include <utility>
#include <vector>

namespace ld {

/// Memory of zeros that the system gives piece by piece when it is touched, in large pages where it can: a
/// gigabyte in pages of 4 kB takes longer to get than to decode. Null when there is none.
void* map_zeros(size_t bytes);
void unmap_zeros(void* memory, size_t bytes);

/// Elements that a vector makes without a value are what map_zeros() gives, untouched.
template <class T>
struct ZeroedAllocator {
  using value_type = T;
  ZeroedAllocator() = default;
  template <class U>
  explicit ZeroedAllocator(const ZeroedAllocator<U>&) {}

  T* allocate(size_t count) {
    void* memory = map_zeros(count * sizeof(T));
    if (memory == nullptr) throw std::bad_alloc();
    return static_cast<T*>(memory);
  }
  void deallocate(T* memory, size_t count) { unmap_zeros(memory, count * sizeof(T)); }
  template <class U, class... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    if constexpr (sizeof...(Arguments) > 0) new (place) U(std::forward<Arguments>(arguments)...);
  }
  bool operator==(const ZeroedAllocator&) const { return true; }
  bool operator!=(const ZeroedAllocator&) const { return false; }
};

/// Zeros when it is made, not where it grows after it was made smaller.
using ZeroedFloats = std::vector<float, ZeroedAllocator<float>>;

}  // namespace ld
