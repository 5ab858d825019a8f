#include "core/threads.h"

#include <sched.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <exception>
#include <mutex>
#include <string>

#include "core/error.h"

namespace ld {

int default_threads() {
  if (const char* text = std::getenv("OMP_NUM_THREADS"); text != nullptr && *text != '\0') {
    char* end = nullptr;
    const long count = std::strtol(text, &end, 10);
    if (end == text || (*end != '\0' && *end != ',') || count < 1 || count > 4096)
      fail_usage(
          "environment variable OMP_NUM_THREADS: expected a number from 1 to 4096, found '{}'; unset it or "
          "pass --threads N",
          text);
    return static_cast<int>(count);
  }
  cpu_set_t set;
  CPU_ZERO(&set);
  if (sched_getaffinity(0, sizeof(set), &set) == 0) return std::max(1, CPU_COUNT(&set));
  return std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

std::vector<std::thread> start_threads(int count, const std::function<void()>& work,
                                       const std::function<void()>& stop) {
  std::vector<std::thread> threads;
  try {
    for (int i = 0; i < count; ++i) threads.emplace_back(work);
  } catch (const std::exception& error) {
    stop();
    for (std::thread& thread : threads) thread.join();
    fail("cannot start thread {} of {}: {}; ask for fewer or raise the limits (ulimit -u, ulimit -v)",
         threads.size() + 1, count, error.what());
  }
  return threads;
}

void parallel_for(int64_t count, int threads, const std::function<void(int64_t)>& body) {
  std::atomic<int64_t> next{0};
  std::exception_ptr first_failure;
  std::mutex failure_mutex;
  const auto work = [&] {
    for (int64_t i = next++; i < count; i = next++) {
      try {
        body(i);
      } catch (const std::exception&) {
        const std::lock_guard<std::mutex> lock(failure_mutex);
        if (!first_failure) first_failure = std::current_exception();
        next = count;
      }
    }
  };
  const auto others = static_cast<int>(std::max<int64_t>(std::min<int64_t>(threads, count) - 1, 0));
  std::vector<std::thread> helpers = start_threads(others, work, [&] { next = count; });
  work();
  for (std::thread& helper : helpers) helper.join();
  if (first_failure) std::rethrow_exception(first_failure);
}

}  // namespace ld
