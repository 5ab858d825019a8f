#include "core/process/child_process.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <stdexcept>

#include "core/file_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

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

TEST(ChildProcess, AnotherProgramLeavesItsCodeAndWhatItPrints) {
  const TemporaryFolder folder;
  const auto shell = [&](const std::string& script) {
    return run_child({"/bin/sh", "-c", script}, folder / "log");
  };
  EXPECT_EQ(shell("echo one; echo two >&2; exit 3"), 3);
  EXPECT_EQ(shell("echo three"), 0);
  EXPECT_EQ(read_file(folder / "log"), "one\ntwo\nthree\n");
  EXPECT_EQ(shell("kill -KILL $$"), 128 + SIGKILL);
  EXPECT_ERROR(run_child({(folder / "none").string()}, folder / "log"), "cannot start");
  EXPECT_ERROR(run_child({"/bin/true"}, folder / "missing/log"), "cannot write");
}

}  // namespace
}  // namespace ld
