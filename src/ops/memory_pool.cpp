#include "ops/memory_pool.h"

#include <c10/core/Allocator.h>
#include <c10/core/CPUAllocator.h>
#include <sys/mman.h>
#include <torch/version.h>

#include <algorithm>
#include <map>
#include <mutex>
#include <new>
#include <unordered_map>

#include "ops/composition.h"

namespace ld {
namespace {

constexpr size_t kSmallest = size_t(1) << 20;
constexpr size_t kHugePage = size_t(2) << 20;

/// Sizes in steps of an eighth of the power of two below: at most an eighth is wasted, and crops of one size
/// always find what the last step left.
size_t size_class(size_t bytes) {
  size_t power = kSmallest;
  while (power * 2 <= bytes) power *= 2;
  const size_t step = power / 8;
  return (bytes + step - 1) / step * step;
}

class Pool {
 public:
  void* take(size_t bytes) {
    const size_t size = size_class(bytes);
    const std::lock_guard<std::mutex> lock(mutex_);
    live_ += size;
    peak_live_ = std::max(peak_live_, live_);
    const auto found = free_.find(size);
    if (found != free_.end()) {
      void* data = found->second;
      free_.erase(found);
      pooled_ -= size;
      sizes_.emplace(data, size);
      return data;
    }
    while (pooled_ > 0 && live_ + pooled_ > peak_live_ + peak_live_ / 8) release_largest();
    // Whole huge pages where the system has them: one fault for 512 pages.
    void* data = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (data == MAP_FAILED) {
      live_ -= size;
      throw std::bad_alloc();
    }
    if (size >= kHugePage) madvise(data, size, MADV_HUGEPAGE);
    sizes_.emplace(data, size);
    return data;
  }

  /// Whether `data` was from here.
  bool give_back(void* data) {
    const std::lock_guard<std::mutex> lock(mutex_);
    const auto found = sizes_.find(data);
    if (found == sizes_.end()) return false;
    live_ -= found->second;
    pooled_ += found->second;
    free_.emplace(found->second, data);
    sizes_.erase(found);
    return true;
  }

  void release_all() {
    const std::lock_guard<std::mutex> lock(mutex_);
    while (!free_.empty()) release_largest();
    peak_live_ = live_;
  }

  MemoryPoolState state() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return {int64_t(live_), int64_t(pooled_), int64_t(peak_live_)};
  }

 private:
  void release_largest() {
    const auto last = std::prev(free_.end());
    munmap(last->second, last->first);
    pooled_ -= last->first;
    free_.erase(last);
  }

  std::mutex mutex_;
  std::multimap<size_t, void*> free_;
  std::unordered_map<void*, size_t> sizes_;  // of what is in use
  size_t live_ = 0, pooled_ = 0, peak_live_ = 0;
};

/// Never destroyed: tensors in static variables outlive every other order.
Pool& pool() {
  static Pool* const instance = new Pool;
  return *instance;
}

c10::Allocator& system_allocator() {
  return *c10::GetDefaultCPUAllocator();
}

/// Also what LibTorch's raw pointers are freed with, from either allocator.
void give_back(void* data) {
  if (!pool().give_back(data)) system_allocator().raw_deleter()(data);
}

c10::DataPtr allocate_data(size_t bytes) {
  if (bytes < kSmallest || composed_operators()) return system_allocator().allocate(bytes);
  void* data = pool().take(bytes);
  return {data, data, &give_back, c10::Device(c10::DeviceType::CPU)};
}

class PoolAllocator : public c10::Allocator {
 public:
// LibTorch 2.6 allocates with a function that is not const, and has allocators copy what they own.
#if TORCH_VERSION_MAJOR >= 2
  c10::DataPtr allocate(size_t bytes) override {
    return allocate_data(bytes);
  }
  void copy_data(void* to, const void* from, size_t bytes) const override {
    default_copy_data(to, from, bytes);
  }
#else
  c10::DataPtr allocate(size_t bytes) const override {
    return allocate_data(bytes);
  }
#endif
  c10::DeleterFnPtr raw_deleter() const override {
    return &give_back;
  }
};

}  // namespace

void use_memory_pool() {
  static PoolAllocator allocator;
  c10::SetCPUAllocator(&allocator, /*priority=*/1);
}

void release_memory_pool() {
  pool().release_all();
}

MemoryPoolState memory_pool_state() {
  return pool().state();
}

}  // namespace ld
