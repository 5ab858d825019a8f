// Checkpoints survive what happens to disks and processes: kills, full disks, lost and damaged files.
#include "training/run/checkpoint_folder.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include "core/file_io.h"
#include "core/random.h"
#include "tests/support/expect_error.h"
#include "tests/support/full_disk.h"
#include "tests/support/killed_process.h"
#include "tests/support/temporary_folder.h"
#include "weights/checkpoint_files.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// Files of a few hundred bytes that tell which step they are of.
void fill(const fs::path& folder, int64_t step) {
  for (const char* name : kCheckpointFiles)
    write_file_atomically(folder / name, std::string(300, static_cast<char>('a' + step % 26)) + name);
}

void write(CheckpointFolder& checkpoints, int64_t step, bool best = false) {
  checkpoints.write(
      step, [&](const fs::path& folder) { fill(folder, step); }, best);
}

class Checkpoints : public ::testing::Test {
 protected:
  fs::path of(int64_t step) const { return checkpoints_ / fmt::format("step_{:08}", step); }
  std::string link(const std::string& name) const {
    const fs::path path = checkpoints_ / name;
    return fs::is_symlink(path) ? fs::read_symlink(path).string() : "";
  }
  std::vector<std::string> names() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(checkpoints_))
      names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
  }

  TemporaryFolder run_;
  fs::path checkpoints_ = run_ / "checkpoints";
  CheckpointFolder folder_{run_.path(), 2};
};

TEST_F(Checkpoints, ARunGoesBackToOneOfThem) {
  for (int64_t step = 10; step <= 40; step += 10) write(folder_, step, step == 20);
  EXPECT_EQ(folder_.newest_whole_until(20), of(20));
  EXPECT_EQ(folder_.newest_whole_until(35), of(30));
  EXPECT_EQ(folder_.newest_whole_until(19), std::nullopt);
  std::ofstream(of(30) / kCheckpointFiles[0], std::ios::app) << "x";
  EXPECT_EQ(folder_.newest_whole_until(35), of(20));
  folder_.go_back_to(20);
  EXPECT_EQ(names(), (std::vector<std::string>{"best", "last", "step_00000020"}));
  EXPECT_EQ(link("last"), "step_00000020");
  EXPECT_EQ(folder_.newest_whole(), of(20));
  write(folder_, 30, true);
  folder_.go_back_to(20);
  EXPECT_EQ(link("best"), "step_00000020") << "what it named is gone";
  folder_.go_back_to(0);
  EXPECT_TRUE(names().empty());
  EXPECT_FALSE(folder_.begun());
}

TEST_F(Checkpoints, TheNewestTwoAndTheBestAreKept) {
  EXPECT_FALSE(folder_.begun());
  EXPECT_FALSE(folder_.newest_whole());
  for (int64_t step = 10; step <= 60; step += 10) write(folder_, step, step == 20);
  EXPECT_EQ(names(),
            (std::vector<std::string>{"best", "last", "step_00000020", "step_00000050", "step_00000060"}));
  EXPECT_EQ(link("last"), "step_00000060");
  EXPECT_EQ(link("best"), "step_00000020");
  EXPECT_TRUE(folder_.restore_best(20));
  EXPECT_FALSE(folder_.restore_best(30));
  EXPECT_EQ(folder_.newest_whole(), of(60));
  EXPECT_TRUE(folder_.begun());
}

TEST_F(Checkpoints, StepsOutgrowTheirDigits) {
  write(folder_, 99999999);
  write(folder_, 100000000);
  EXPECT_EQ(folder_.newest_whole(), checkpoints_ / "step_100000000");
}

TEST_F(Checkpoints, WhatKilledProcessesLeftIsRemoved) {
  fs::create_directories(checkpoints_ / ".step_00000005.123.partial");
  write(folder_, 10);
  EXPECT_EQ(names(), (std::vector<std::string>{"last", "step_00000010"}));
}

TEST_F(Checkpoints, AKillAtAnyMomentOfSavingAStepAgainLeavesItWhole) {
  const fs::path run = "/dev/shm/ld_test_" + std::to_string(getpid());  // flushing takes no time there
  checkpoints_ = run / "checkpoints";
  folder_ = CheckpointFolder(run, 2);
  Ended ended = Ended::killed;
  for (int call = 1; ended == Ended::killed; ++call) {
    SCOPED_TRACE(fmt::format("killed at system call {}", call));
    fs::remove_all(checkpoints_);
    write(folder_, 10, true);
    ended = run_until_call(call, [&] { write(folder_, 10, true); });
    CheckpointFolder again(run, 2);
    EXPECT_TRUE(again.begun());
    ASSERT_EQ(again.newest_whole(), of(10));
    EXPECT_TRUE(again.restore_best(10));
    EXPECT_EQ(link("last"), "step_00000010");
    EXPECT_EQ(link("best"), "step_00000010");
    write(again, 20);
    EXPECT_EQ(names(), (std::vector<std::string>{"best", "last", "step_00000010", "step_00000020"}));
  }
  fs::remove_all(run);
  if (ended == Ended::untraceable) GTEST_SKIP() << "no process may be traced here";
}

TEST_F(Checkpoints, OneThatWasToBeReplacedComesBack) {
  const fs::path aside = checkpoints_ / ".step_00000010.replaced";
  const fs::path partial = checkpoints_ / ".step_00000010.123.partial";
  write(folder_, 10, true);
  fs::rename(of(10), aside);  // killed before the new one was there
  fs::create_directories(partial);
  fill(partial, 11);
  EXPECT_TRUE(folder_.begun());
  EXPECT_EQ(folder_.newest_whole(), of(10));
  EXPECT_EQ(link("last"), "step_00000010");
  EXPECT_NO_THROW(verify_checkpoint(of(10)));

  fs::create_directories(aside);  // killed before what was left of the old one was removed
  EXPECT_EQ(folder_.newest_whole(), of(10));
  EXPECT_FALSE(fs::exists(aside));
  write(folder_, 20);

  fs::rename(of(20), checkpoints_ / ".step_00000020.replaced");
  folder_.go_back_to(10);  // forgets all after it, also what was to be replaced
  EXPECT_EQ(folder_.newest_whole(), of(10));
  EXPECT_EQ(names(), (std::vector<std::string>{"best", "last", "step_00000010"}));
}

TEST_F(Checkpoints, TwoProcessesOfOneNumberDoNotShareAFolder) {
  std::vector<std::string> names;  // as in two containers on one disk
  for (int i = 0; i < 2; ++i)
    folder_.write(
        10,
        [&](const fs::path& folder) {
          names.push_back(folder.filename().string());
          fill(folder, 10);
        },
        false);
  EXPECT_NE(names.at(0), names.at(1));
}

TEST_F(Checkpoints, ALinkThatAKilledProcessDidNotPutInPlaceIsRemoved) {
  fs::create_directories(checkpoints_);
  fs::create_symlink("step_00000005", checkpoints_ / ".last.123.partial");
  write(folder_, 10);
  EXPECT_EQ(names(), (std::vector<std::string>{"last", "step_00000010"}));
}

TEST_F(Checkpoints, TruncationsAndFlippedBitsAreRefusedByName) {
  write(folder_, 10);
  write(folder_, 20);
  std::vector<std::string> files(kCheckpointFiles.begin(), kCheckpointFiles.end());
  files.emplace_back("checksums.json");
  RandomStream stream(1, RandomPurpose::test);
  for (int damage = 0; damage < 150; ++damage) {
    const std::string file = files[stream.below(static_cast<uint32_t>(files.size()))];
    std::string bytes = read_file(of(20) / file);
    const std::string whole = bytes;
    const uint32_t at = stream.below(static_cast<uint32_t>(bytes.size()));
    SCOPED_TRACE(fmt::format("{} {} at {}", damage < 50 ? "cut" : "flipped", file, at));
    if (damage < 50)
      bytes.resize(at);
    else
      bytes[at] = static_cast<char>(bytes[at] ^ (1 << stream.below(8)));
    std::ofstream(of(20) / file, std::ios::binary) << bytes;
    EXPECT_ERROR(verify_checkpoint(of(20)), of(20).string());
    EXPECT_EQ(folder_.newest_whole(), of(10));
    EXPECT_EQ(link("last"), "step_00000010");
    EXPECT_FALSE(fs::exists(of(20)));
    // What was damaged stays for looking at.
    const fs::path aside = checkpoints_ / "damaged_step_00000020";
    EXPECT_EQ(read_file(aside / file), bytes);
    std::ofstream(aside / file, std::ios::binary) << whole;
    fs::rename(aside, of(20));
  }
  EXPECT_EQ(folder_.newest_whole(), of(20));
}

TEST_F(Checkpoints, MissingFilesAndLinks) {
  for (const int64_t step : {10, 20, 30}) write(folder_, step);
  fs::remove(of(30) / "optimizer.safetensors");
  EXPECT_EQ(folder_.newest_whole(), of(20));
  fs::remove(checkpoints_ / "last");
  EXPECT_EQ(folder_.newest_whole(), of(20));
  EXPECT_EQ(link("last"), "step_00000020");
  fs::remove_all(of(20));
  EXPECT_ERROR(folder_.newest_whole(), "names step_00000020, which is not there");
  fs::create_directories(of(40));
  EXPECT_ERROR(folder_.newest_whole(), "no checkpoint is whole");
  EXPECT_ERROR(folder_.newest_whole(), "step_00000040");
}

TEST_F(Checkpoints, ALostBestIsNoticed) {
  write(folder_, 10, true);
  write(folder_, 20);
  EXPECT_TRUE(folder_.restore_best(10));
  fs::remove(checkpoints_ / "best");
  EXPECT_TRUE(folder_.restore_best(10));
  EXPECT_EQ(link("best"), "step_00000010");
  std::ofstream(of(10) / "weights.safetensors", std::ios::app) << "x";
  EXPECT_FALSE(folder_.restore_best(10));
  EXPECT_EQ(link("best"), "step_00000010");
  EXPECT_TRUE(folder_.restore_best(20));
  EXPECT_EQ(link("best"), "step_00000020");
  EXPECT_FALSE(folder_.restore_best(30));
}

TEST_F(Checkpoints, AFullDiskCostsNoOlderCheckpoint) {
  write(folder_, 10, true);
  for (const size_t room : {0, 100, 318, 320}) {
    SCOPED_TRACE(room);
    const FileSizeLimit limit(room);
    EXPECT_ERROR(write(folder_, 20, true), "File too large");
  }
  EXPECT_EQ(names(), (std::vector<std::string>{"best", "last", "step_00000010"}));
  EXPECT_EQ(folder_.newest_whole(), of(10));
  EXPECT_EQ(link("best"), "step_00000010");
  write(folder_, 20);
  EXPECT_EQ(folder_.newest_whole(), of(20));
}

TEST_F(Checkpoints, ADiskThatFillsUpKeepsWhatItHas) {
  SmallDisk disk(run_ / "disk");
  if (!disk.mount_with("64k")) GTEST_SKIP() << "cannot mount a small disk: " << std::strerror(errno);
  CheckpointFolder small(run_ / "disk", 1000);
  int64_t step = 0;
  std::string text;
  while (text.empty() && step < 100) {
    try {
      write(small, step + 1);
      ++step;
    } catch (const Error& error) {
      text = error.what();
    }
  }
  EXPECT_NE(text.find("No space left on device"), std::string::npos) << text;
  ASSERT_GT(step, 0);
  EXPECT_EQ(small.newest_whole(), run_ / "disk/checkpoints" / fmt::format("step_{:08}", step));
  ASSERT_TRUE(disk.mount_with("1m"));
  write(small, step + 1);
  EXPECT_EQ(small.newest_whole(), run_ / "disk/checkpoints" / fmt::format("step_{:08}", step + 1));
}

TEST_F(Checkpoints, AFolderThatCannotBeWrittenIsAnErrorOfOurs) {
  std::ofstream(run_ / "checkpoints") << "a file in its place";
  EXPECT_ERROR(write(folder_, 10), "checkpoints");
}

}  // namespace
}  // namespace ld
