// Threads that the system refuses to start. For one source file of a test program.
#pragma once

#include <dlfcn.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>

namespace ld {

/// Threads that may still start; below 0: any number.
inline std::atomic<int> threads_left{-1};

/// While it lives, this process can start so many threads and no more, as where a limit of processes or of
/// memory is reached.
class ThreadLimit {
 public:
  explicit ThreadLimit(int threads) { threads_left = threads; }
  ~ThreadLimit() { threads_left = -1; }
  ThreadLimit(const ThreadLimit&) = delete;
  ThreadLimit& operator=(const ThreadLimit&) = delete;
};

}  // namespace ld

/// Stands before the C library's function of that name, which std::thread calls: root knows no limit of
/// processes, and a limit of memory would hit more than threads.
extern "C" int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                              void* argument) noexcept {
  using Create = int (*)(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*);
  static const auto create = reinterpret_cast<Create>(dlsym(RTLD_NEXT, "pthread_create"));
  if (ld::threads_left == 0) return EAGAIN;
  if (ld::threads_left > 0) --ld::threads_left;
  return create(thread, attributes, start, argument);
}
