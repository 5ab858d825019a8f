#include "core/file_io.h"

#include <gtest/gtest.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <set>
#include <string>
#include <vector>

#include "core/checksum.h"
#include "core/error.h"
#include "tests/support/temporary_folder.h"

namespace {

std::vector<std::string> flushed;  // what fsync() was called for, in this order

}  // namespace

/// Stands before the C library's function of that name and keeps a record: what a power cut takes cannot be
/// tried out.
extern "C" int fsync(int descriptor) {
  const std::filesystem::path of_descriptor = "/proc/self/fd/" + std::to_string(descriptor);
  flushed.push_back(std::filesystem::read_symlink(of_descriptor).string());
  return static_cast<int>(syscall(SYS_fsync, descriptor));
}

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

TEST(FileIo, TwoWritersOfOneFileNeverShareATemporaryFile) {
  const TemporaryFolder folder;
  std::set<std::string> names;
  // As in two containers, both writers have the same number of the process.
  write_atomically(folder / "file", [&](const std::filesystem::path& outer) {
    names.insert(outer.filename().string());
    write_atomically(folder / "file", [&](const std::filesystem::path& inner) {
      names.insert(inner.filename().string());
      write_file_atomically(inner, "inner");
    });
    EXPECT_EQ(read_file(folder / "file"), "inner");
    EXPECT_TRUE(std::filesystem::exists(outer)) << "the other writer took it away";
    write_file_atomically(outer, "outer");
  });
  EXPECT_EQ(names.size(), 2u);
  EXPECT_EQ(read_file(folder / "file"), "outer");
  EXPECT_EQ(files_in(folder.path()), 1u);
}

TEST(FileIo, NewFoldersAreFlushedWithTheFolderThatNamesThem) {
  const TemporaryFolder folder;
  const std::string base = std::filesystem::canonical(folder.path()).string();
  flushed.clear();
  make_folder(folder / "a/b/c");
  EXPECT_EQ(flushed, (std::vector<std::string>{base, base + "/a", base + "/a/b"}));
  flushed.clear();
  make_folder(folder / "a/b");
  make_folder(folder / "a/b/");
  EXPECT_TRUE(flushed.empty()) << "nothing is new";
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  make_folder("x/./y/");
  std::filesystem::current_path(before);
  const std::set<std::string> folders(flushed.begin(), flushed.end());
  EXPECT_TRUE(folders.count(base) == 1 && folders.count(base + "/x") == 1);
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
