// ld_render killed at any time goes on and ends with the same bytes; a full disk is reported and loses
// nothing.
#include <gtest/gtest.h>

#include <chrono>
#include <cstring>
#include <map>
#include <thread>

#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "tests/support/full_disk.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// The bytes of all files of a data set by name; hidden ones are locks and what a killed process left.
std::map<std::string, std::string> contents(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().filename().string()[0] != '.')
      files[entry.path().filename().string()] = read_file(entry.path());
  return files;
}

void expect_equal(const fs::path& folder, const std::map<std::string, std::string>& whole) {
  const auto files = contents(folder);
  EXPECT_EQ(files.size(), whole.size());
  for (const auto& [name, bytes] : whole) {
    const auto found = files.find(name);
    EXPECT_TRUE(found != files.end() && found->second == bytes) << name << " differs or is missing";
  }
}

/// Every file that has its final name is whole.
void expect_whole_files(const fs::path& folder, const std::map<std::string, std::string>& whole) {
  if (!fs::exists(folder)) return;
  for (const auto& [name, bytes] : contents(folder)) {
    if (name == "manifest.json") {
      EXPECT_NO_THROW(read_manifest(folder));
    } else {
      const auto expected = whole.find(name);
      EXPECT_TRUE(expected != whole.end() && expected->second == bytes) << "a half-written " << name;
    }
  }
}

class Interruption : public ::testing::Test {
 protected:
  void SetUp() override {
    write_file_atomically(folder_ / "recipe.yaml",
                          "resolution: [24, 24]\nspp: 4\nreference_spp: {train: 64, test: 64}\n"
                          "frames: {train: 4, validation: 0, test: 1}\nscenes: {variety: simple, objects: "
                          "[2, 3], outdoor_objects: [2, 3]}\n");
    const auto start = std::chrono::steady_clock::now();
    const ProgramResult result = run_program("ld_render", arguments(folder_ / "whole"));
    ASSERT_EQ(result.exit_code, 0) << result.output;
    seconds_ = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    whole_ = contents(folder_ / "whole");
    ASSERT_EQ(whole_.size(), 11u);  // two files a frame and the manifest
  }

  std::vector<std::string> arguments(const fs::path& out, const std::string& frames = "0:5") const {
    return {"--recipe",  (folder_ / "recipe.yaml").string(),
            "--out",     out.string(),
            "--frames",  frames,
            "--threads", "2"};
  }
  void finish(const fs::path& out) const {
    const ProgramResult result = run_program("ld_render", arguments(out));
    EXPECT_EQ(result.exit_code, 0) << result.output;
    expect_equal(out, whole_);
  }

  TemporaryFolder folder_;
  double seconds_ = 0;
  std::map<std::string, std::string> whole_;
};

TEST_F(Interruption, KilledAtAnyTimeItEndsWithTheSameBytes) {
  constexpr int kMoments = 6;
  int killed = 0;
  for (int moment = 0; moment < kMoments; ++moment) {
    SCOPED_TRACE("moment " + std::to_string(moment));
    const fs::path out = folder_ / ("killed_" + std::to_string(moment));
    RunningProgram program("ld_render", arguments(out));
    std::this_thread::sleep_for(std::chrono::duration<double>(seconds_ * (moment + 0.5) / kMoments));
    program.signal(SIGKILL);
    if (program.wait() == -SIGKILL) ++killed;
    expect_whole_files(out, whole_);
    finish(out);
  }
  EXPECT_GE(killed, kMoments / 2) << "the others had finished in time";
}

TEST_F(Interruption, NoRoomForAFrameIsReportedAndLosesNothing) {
  const fs::path out = folder_ / "full";
  ASSERT_EQ(run_program("ld_render", arguments(out, "0:2")).exit_code, 0);
  const auto before = contents(out);
  ProgramResult result;
  {
    const FileSizeLimit limit(whole_.at("frame_000003.exr").size() / 2);
    result = run_program("ld_render", arguments(out));
  }
  expect_failure(result, 1, {"ld_render: cannot write", "frame_00000", "File too large"});
  expect_whole_files(out, whole_);
  for (const auto& [name, bytes] : before) EXPECT_EQ(contents(out)[name], bytes) << name;
  for (const auto& entry : fs::directory_iterator(out))
    EXPECT_EQ(entry.path().string().find("partial"), std::string::npos) << entry.path();
  finish(out);
}

TEST(FullDisk, TheLastBytesCountAsMuchAsTheFirst) {
  // Libraries write the end of a file when they close it, where nobody looks for errors.
  const TemporaryFolder folder;
  const Frame frame = random_frame(40, 30, 2);
  Image image(90, 90, 3);
  for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = frame.samples[i % frame.samples.size()];
  write_frame(folder / "frame.exr", frame);
  write_image(folder / "image.exr", image);
  write_image(folder / "image.png", image);
  for (const std::string& name : std::vector<std::string>{"frame.exr", "image.exr", "image.png"}) {
    const std::string bytes = read_file(folder / name);
    for (const size_t missing : {size_t{1}, size_t{100}, size_t{5000}, bytes.size() - 10}) {
      SCOPED_TRACE(name + " without " + std::to_string(missing) + " bytes");
      const fs::path path = folder / ("full_" + name);
      std::string text;
      {
        const FileSizeLimit limit(bytes.size() - missing);
        try {
          if (name == "frame.exr")
            write_frame(path, frame);
          else
            write_image(path, image);
        } catch (const std::exception& error) {
          text = error.what();
        }
      }
      EXPECT_NE(text.find("full_" + name), std::string::npos) << text;
      EXPECT_FALSE(fs::exists(path));
    }
  }
}

TEST_F(Interruption, AFullDiskIsReportedAndLosesNothing) {
  SmallDisk disk(folder_ / "disk");
  size_t bytes = 0;
  for (const auto& [name, content] : whole_) bytes += content.size();
  if (!disk.mount_with(std::to_string(bytes / 2)))
    GTEST_SKIP() << "cannot mount a small disk: " << std::strerror(errno);
  const fs::path out = folder_ / "disk/data";
  expect_failure(run_program("ld_render", arguments(out)), 1, {"ld_render: cannot write", "disk"});
  expect_whole_files(out, whole_);
  EXPECT_GT(contents(out).size(), 1u) << "some frames had room";
  const size_t held = read_manifest(out).frames.size();
  EXPECT_GT(held, 0u);
  ASSERT_TRUE(disk.mount_with(std::to_string(4 * bytes)));
  EXPECT_EQ(read_manifest(out).frames.size(), held);
  finish(out);
}

}  // namespace
}  // namespace ld
