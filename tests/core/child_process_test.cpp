#include "core/process/child_process.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>

namespace ld {
namespace {

TEST(ChildProcess, SaysWhetherTheWorkCameToItsEnd) {
  EXPECT_TRUE(survives_in_a_child([] {}));
  EXPECT_TRUE(survives_in_a_child([] { throw std::runtime_error("met again by the caller"); }));
  EXPECT_FALSE(survives_in_a_child([] { raise(SIGKILL); }));
  EXPECT_FALSE(survives_in_a_child([] { std::abort(); }));
  EXPECT_FALSE(survives_in_a_child([] { _exit(0); }));
}

TEST(ChildProcess, LeavesTheCallersMemoryAlone) {
  int value = 1;
  EXPECT_TRUE(survives_in_a_child([&] { value = 2; }));
  EXPECT_EQ(value, 1);
}

}  // namespace
}  // namespace ld
