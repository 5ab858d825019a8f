#include "core/progress.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

namespace ld {
namespace {

/// What stands on standard error, which is no terminal, after three steps of which the last takes `seconds`.
std::string shown_of_work(double seconds) {
  testing::internal::CaptureStderr();
  {
    Progress progress("frames", 3);
    progress.advance(2);
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds));
    progress.advance(1, "almost");
  }
  return testing::internal::GetCapturedStderr();
}

TEST(Progress, WorkThatTakesAMomentShowsNone) {
  EXPECT_EQ(shown_of_work(0), "");
}

TEST(Progress, LongWorkEndsWithALine) {
  EXPECT_EQ(shown_of_work(2.2), "frames 3/3, 2s in all, almost\n");
}

}  // namespace
}  // namespace ld
