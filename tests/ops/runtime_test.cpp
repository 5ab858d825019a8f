// What a library changes in somebody else's program, and that it changes it back.
#include "ops/runtime.h"

#include <ATen/Parallel.h>
#include <gtest/gtest.h>
#include <torch/torch.h>

#include <limits>
#include <vector>

namespace ld {
namespace {

constexpr int kThreads = 3;

bool thread_flushes() {
  volatile float smallest = std::numeric_limits<float>::min();
  volatile float half = smallest / 2;
  return half == 0;
}

/// Of each thread of the pool, the calling one first.
std::vector<bool> pool_flushes() {
  std::vector<char> flushes(kThreads, 2);
  at::parallel_for(0, kThreads, 1, [&](int64_t begin, int64_t end) {
    for (int64_t n = begin; n < end; ++n) flushes[static_cast<size_t>(n)] = thread_flushes() ? 1 : 0;
  });
  return {flushes.begin(), flushes.end()};
}

void set_pool(const std::vector<bool>& flush) {
  at::parallel_for(0, kThreads, 1, [&](int64_t begin, int64_t) {
    at::globalContext().setFlushDenormal(flush[static_cast<size_t>(begin)]);
  });
}

TEST(RuntimeGuard, LeavesEachThreadAsItWas) {
  at::set_num_threads(kThreads);
  for (const std::vector<bool>& before : {std::vector<bool>{false, false, false},
                                          {true, true, true},
                                          {false, true, true},
                                          {true, false, true}}) {
    set_pool(before);
    ASSERT_EQ(pool_flushes(), before);
    {
      const RuntimeGuard guard(kThreads);
      EXPECT_EQ(pool_flushes(), std::vector<bool>(kThreads, true));
    }
    EXPECT_EQ(pool_flushes(), before);
    EXPECT_EQ(thread_flushes(), before[0]);
  }
}

TEST(RuntimeGuard, GivesTheNumberOfThreadsBack) {
  at::set_num_threads(kThreads);
  set_pool({false, false, false});
  {
    const RuntimeGuard guard(1);
    EXPECT_EQ(at::get_num_threads(), 1);
    EXPECT_TRUE(thread_flushes());
  }
  EXPECT_EQ(at::get_num_threads(), kThreads);
  EXPECT_EQ(pool_flushes(), std::vector<bool>(kThreads, false));
}

}  // namespace
}  // namespace ld
