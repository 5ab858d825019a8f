// Denormals flushed while a graph runs: fading activations would slow the arithmetic a hundredfold.
#pragma once

#include <omp.h>

#include <cfenv>
#include <cstdint>
#include <vector>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

namespace ld {

/// While it lives, the threads of parallel_for (runtime/parallel.h) flush denormals to zero; then their
/// floating-point settings are what they were. OpenMP gives the n-th thread of a region to the n-th of the
/// one before, as long as the number of threads is the same.
class FlushedDenormals {
 public:
  explicit FlushedDenormals(int threads) {
    std::fenv_t callers{};
    std::fegetenv(&callers);
    before_.assign(size_t(threads), callers);  // there may be fewer threads than that
    each([](std::fenv_t& before) {
      std::fegetenv(&before);
      flush();
    });
  }
  ~FlushedDenormals() {
    each([](std::fenv_t& before) { std::fesetenv(&before); });
  }
  FlushedDenormals(const FlushedDenormals&) = delete;
  FlushedDenormals& operator=(const FlushedDenormals&) = delete;

 private:
  template <class Body>
  void each(const Body& body) {
    if (before_.size() == 1) return body(before_[0]);
#pragma omp parallel num_threads(int(before_.size()))
    body(before_[size_t(omp_get_thread_num())]);
  }

  static void flush() {
#if defined(__SSE__)
    _mm_setcsr(_mm_getcsr() | 0x8040);  // flush to zero, denormals are zero
#elif defined(__aarch64__)
    uint64_t control = 0;
    asm volatile("mrs %0, fpcr" : "=r"(control));
    asm volatile("msr fpcr, %0" : : "r"(control | (uint64_t(1) << 24)));
#endif
  }

  std::vector<std::fenv_t> before_;  // of each thread
};

}  // namespace ld
