#include "dataset/prefetch.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>

#include "core/error.h"
#include "tests/support/expect_error.h"
#include "tests/support/thread_limit.h"

namespace ld {
namespace {

TEST(Prefetch, GivesWhatIsAskedForWithAnyNumberOfWorkers) {
  for (const int workers : {0, 1, 2, 5}) {
    Prefetch<int64_t> squares(
        [](int64_t number) {
          // Later ones are ready first.
          std::this_thread::sleep_for(std::chrono::microseconds(300 * (3 - number % 4)));
          return number * number;
        },
        workers);
    for (const int64_t number : {5, 6, 7, 8, 9, 3, 4, 3, 100, 101})
      EXPECT_EQ(squares.get(number), number * number) << workers << " workers";
  }
}

TEST(Prefetch, TheQueueIsBounded) {
  std::atomic<int> made{0};
  Prefetch<int> items([&](int64_t) { return ++made; }, 2);
  EXPECT_EQ(made, 0) << "nothing is made before it is known where to begin";
  items.get(0);
  for (int i = 0; i < 100 && made < 4; ++i) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  std::this_thread::sleep_for(std::chrono::milliseconds(30));
  EXPECT_EQ(made, 4);  // the one that was taken and workers + 1 more
}

TEST(Prefetch, AnErrorReachesTheCallerAsItIs) {
  for (const int workers : {0, 1, 5}) {
    Prefetch<int64_t> items(
        [](int64_t number) {
          if (number == 2) fail_usage("number {} is bad", number);
          return number;
        },
        workers);
    EXPECT_EQ(items.get(1), 1);
    try {
      items.get(2);
      ADD_FAILURE() << "no error with " << workers << " workers";
    } catch (const UsageError& error) {
      EXPECT_STREQ(error.what(), "number 2 is bad");
    }
    EXPECT_EQ(items.get(3), 3);
    EXPECT_THROW(items.get(2), UsageError);
  }
}

TEST(Prefetch, AWorkerThatCannotStartIsAnErrorOfOneLine) {
  const auto make = [](int64_t number) { return number; };
  for (const int allowed : {1, 3, 0}) {
    const ThreadLimit limit(allowed);
    EXPECT_ERROR(Prefetch<int64_t>(make, 5),
                 "cannot start thread " + std::to_string(allowed + 1) + " of 5: Resource temporarily");
  }
  Prefetch<int64_t> items(make, 5);
  EXPECT_EQ(items.get(7), 7);
}

TEST(Prefetch, EndsWhileItsWorkersWork) {
  for (int i = 0; i < 20; ++i) {
    Prefetch<int64_t> items([](int64_t number) { return number; }, 3);
    if (i % 2 == 0) items.get(7);
  }
  SUCCEED();
}

}  // namespace
}  // namespace ld
