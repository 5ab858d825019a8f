// What a graph that runs changes in somebody else's threads, and that it changes it back.
#include "runtime/denormals.h"

#include <gtest/gtest.h>

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
#pragma omp parallel num_threads(kThreads)
  flushes[size_t(omp_get_thread_num())] = thread_flushes() ? 1 : 0;
  return {flushes.begin(), flushes.end()};
}

/// How the second thread rounds from now on, and how it did.
int set_rounding(int rounding) {
  int before = 0;
#pragma omp parallel num_threads(kThreads)
  if (omp_get_thread_num() == 1) {
    before = std::fegetround();
    std::fesetround(rounding);
  }
  return before;
}

TEST(FlushedDenormals, LeavesEachThreadAsItWas) {
  ASSERT_EQ(pool_flushes(), std::vector<bool>(kThreads, false));
  set_rounding(FE_UPWARD);
  {
    const FlushedDenormals all(kThreads);
    EXPECT_EQ(pool_flushes(), std::vector<bool>(kThreads, true));
    {
      const FlushedDenormals again(kThreads);
      EXPECT_EQ(pool_flushes(), std::vector<bool>(kThreads, true));
    }
    EXPECT_EQ(pool_flushes(), std::vector<bool>(kThreads, true)) << "as it was: flushing";
  }
  EXPECT_EQ(pool_flushes(), std::vector<bool>(kThreads, false));
  EXPECT_EQ(set_rounding(FE_TONEAREST), FE_UPWARD);
}

TEST(FlushedDenormals, OfOneThreadIsThatOfTheCaller) {
  {
    const FlushedDenormals one(1);
    EXPECT_TRUE(thread_flushes());
  }
  EXPECT_FALSE(thread_flushes());
}

}  // namespace
}  // namespace ld
