#include "core/process/unnamed_file.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

TEST(UnnamedFile, HoldsWhatWasWrittenAndHasNoName) {
  const TemporaryFolder folder;
  UnnamedFile file(folder / "made" / "here");
  const std::string first = "first", second(1 << 20, 'x');
  file.write(0, first.data(), first.size());
  file.write(5, second.data(), second.size());
  std::string found(second.size(), ' ');
  file.read(5, found.data(), found.size());
  EXPECT_EQ(found, second);
  file.read(0, found.data(), 5);
  EXPECT_EQ(found.substr(0, 5), first);
  EXPECT_TRUE(std::filesystem::is_empty(folder / "made" / "here"));
  EXPECT_ERROR(file.read(1 << 20, found.data(), found.size()), "it ends before");
}

TEST(UnnamedFile, SaysWhereItCannotBe) {
  EXPECT_ERROR(UnnamedFile("/proc/nowhere"), "/proc/nowhere");
}

}  // namespace
}  // namespace ld
