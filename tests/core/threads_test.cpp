#include "core/threads.h"

#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <vector>

#include "core/error.h"
#include "core/progress.h"
#include "tests/support/expect_error.h"
#include "tests/support/thread_limit.h"

namespace ld {
namespace {

TEST(Threads, ParallelForVisitsEachIndexOnce) {
  for (const int threads : {1, 2, 5}) {
    std::vector<int> visits(1000);
    parallel_for(1000, threads, [&](int64_t i) { ++visits[static_cast<size_t>(i)]; });
    for (const int count : visits) ASSERT_EQ(count, 1);
  }
  parallel_for(0, 4, [](int64_t) { FAIL(); });
}

TEST(Threads, TheFirstExceptionArrives) {
  EXPECT_THROW(parallel_for(100, 3,
                            [](int64_t i) {
                              if (i == 50) fail("fifty");
                            }),
               Error);
}

TEST(Threads, OneThatCannotStartIsAnErrorOfOneLine) {
  for (const int allowed : {1, 3, 0}) {
    const ThreadLimit limit(allowed);
    std::atomic<int> visits{0};
    EXPECT_ERROR(parallel_for(1000000, 8, [&](int64_t) { ++visits; }),
                 "cannot start thread " + std::to_string(allowed + 1) + " of 7: Resource temporarily");
    EXPECT_LT(visits, 1000000) << "the threads that had started went on";
  }
  std::atomic<int> visits{0};
  parallel_for(1000, 8, [&](int64_t) { ++visits; });
  EXPECT_EQ(visits, 1000);
}

TEST(Threads, TheEnvironmentOverrides) {
  setenv("OMP_NUM_THREADS", "3", 1);
  EXPECT_EQ(default_threads(), 3);
  setenv("OMP_NUM_THREADS", "none", 1);
  EXPECT_THROW(default_threads(), UsageError);
  unsetenv("OMP_NUM_THREADS");
  EXPECT_GE(default_threads(), 1);
}

TEST(Progress, TimesReadWell) {
  EXPECT_EQ(duration_text(7.4), "7s");
  EXPECT_EQ(duration_text(200), "3m20s");
  EXPECT_EQ(duration_text(3725), "1h02m");
}

}  // namespace
}  // namespace ld
