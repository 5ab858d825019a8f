#include "core/file_io.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include "core/checksum.h"
#include "core/error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

size_t files_in(const std::filesystem::path& folder) {
  size_t count = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder)) ++count;
  return count;
}

TEST(FileIo, WritesWholeFilesAndReadsThemBack) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "deep/er/file.bin", std::string("a\0b", 3));
  EXPECT_EQ(read_file(folder / "deep/er/file.bin"), std::string("a\0b", 3));
  EXPECT_EQ(files_in(folder / "deep/er"), 1u);
}

TEST(FileIo, FilesInMemoryAreFilesLikeOthers) {
  const std::filesystem::path folder = "/dev/shm/ld_test_" + std::to_string(getpid());
  write_file_atomically(folder / "new" / "a.json", "1");  // makes the folder, as everywhere
  const std::filesystem::path real = folder / "new" / "a.json";
  std::filesystem::create_symlink(real, folder / "link");
  write_file_atomically(folder / "link", "2");
  EXPECT_EQ(read_file(real), "2");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link"));
  std::filesystem::remove_all(folder);
}

TEST(FileIo, AFailedWriteLeavesTheOldFileAndNoRest) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "file", "old");
  EXPECT_THROW(write_atomically(folder / "file",
                                [](const std::filesystem::path& path) {
                                  write_file_atomically(path, "half");
                                  fail("the disk is on fire");
                                }),
               Error);
  EXPECT_EQ(read_file(folder / "file"), "old");
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(FileIo, ComplainsOfMissingFoldersAndTooLargeFiles) {
  const TemporaryFolder folder;
  EXPECT_THROW(read_file(folder / "none"), Error);
  EXPECT_THROW(read_file(folder.path()), Error);
  write_file_atomically(folder / "file", "12345");
  EXPECT_THROW(read_file(folder / "file", 4), Error);
}

TEST(Checksum, MatchesThePublishedValueAndTheFile) {
  EXPECT_EQ(checksum("", 0), 0x2d06800538d394c2ULL);  // XXH3's test vector for no input
  const TemporaryFolder folder;
  write_file_atomically(folder / "file", "12345");
  EXPECT_EQ(file_checksum(folder / "file"), checksum_text("12345", 5));
  EXPECT_THROW(file_checksum(folder / "none"), Error);
}

}  // namespace
}  // namespace ld
