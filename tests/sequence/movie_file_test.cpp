// Films: through ffmpeg where the machine has it, else as pictures; always with a program that stands for it.
#include "sequence/movie_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>

#include "core/error.h"
#include "core/file_io.h"
#include "frame/frame_file.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {
namespace fs = std::filesystem;

/// A folder of its own that is PATH while the test runs.
class MovieFile : public testing::Test {
 protected:
  void SetUp() override {
    path_ = std::getenv("PATH");
    folder_ = fs::path(testing::TempDir()) / "movie_file_test";
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "bin");
    setenv("PATH", (folder_ / "bin").c_str(), 1);
  }
  void TearDown() override { setenv("PATH", path_.c_str(), 1); }

  /// A program of this name that the shell runs.
  void make_ffmpeg(const std::string& script) {
    const fs::path file = folder_ / "bin/ffmpeg";
    std::ofstream(file) << "#!/bin/sh\nPATH=/usr/bin:/bin\n" << script << "\n";
    chmod(file.c_str(), 0755);
  }

  std::string path_;
  fs::path folder_;
};

Image grey(int width, int height, float value) {
  Image image(width, height, 3);
  for (float& x : image.pixels) x = value;
  return image;
}

TEST_F(MovieFile, WithoutFfmpegThePicturesAreWritten) {
  const auto picture = [](size_t i) { return grey(5, 3, 0.1F * static_cast<float>(i)); };
  const fs::path written = write_movie(folder_ / "shot.mp4", 24, 3, picture);
  EXPECT_EQ(written, folder_ / "shot");
  for (size_t i = 0; i < 3; ++i) {
    const fs::path file = written / ("00000" + std::to_string(i) + ".png");
    EXPECT_EQ(read_file(file), png_bytes(file, picture(i)));
  }
  EXPECT_FALSE(fs::exists(folder_ / "shot.mp4"));
}

TEST_F(MovieFile, FfmpegGetsTheSizeAndEveryPixel) {
  make_ffmpeg("for last; do :; done; echo \"$@\" > " + (folder_ / "arguments").string() +
              "; cat > \"$last\"");
  const fs::path file = folder_ / "a film'; $(x).mp4";
  EXPECT_EQ(write_movie(file, 23.976, 2, [](size_t i) { return grey(4, 2, i == 0 ? 0.0F : 1e30F); }), file);
  EXPECT_EQ(read_file(file), std::string(24, '\0') + std::string(24, '\xff'));
  const std::string arguments = read_file(folder_ / "arguments");
  EXPECT_NE(arguments.find("-s 4x2 -r 23.976 -i pipe:0"), std::string::npos) << arguments;
  EXPECT_NE(arguments.find("libx264"), std::string::npos);
  write_movie(folder_ / "B.WEBM", 24, 1, [](size_t) { return grey(1, 1, 0); });
  EXPECT_NE(read_file(folder_ / "arguments").find("libvpx-vp9"), std::string::npos);
}

TEST_F(MovieFile, AnFfmpegThatFailsLeavesNothingAndIsQuoted) {
  make_ffmpeg("echo 'Unknown encoder' >&2; exit 3");
  // More than a socket holds, so that writing meets the end of the program.
  const std::string error =
      error_text([&] { write_movie(folder_ / "x.mp4", 24, 4, [](size_t) { return grey(900, 700, 1); }); });
  EXPECT_NE(error.find("ended with code 3: Unknown encoder"), std::string::npos) << error;
  EXPECT_EQ(std::distance(fs::directory_iterator(folder_), {}), 1) << "only bin/";
}

TEST_F(MovieFile, OtherNamesAndSizesAreErrors) {
  const auto picture = [](size_t i) { return grey(i == 2 ? 4 : 5, 3, 0); };
  EXPECT_NE(
      error_text([&] { write_movie(folder_ / "x.avi", 24, 1, picture); }).find("expected .mp4 or .webm"),
      std::string::npos);
  EXPECT_NE(error_text([&] { write_movie(folder_ / "x.mp4", 24, 0, picture); }).find("no pictures"),
            std::string::npos);
  make_ffmpeg("cat > /dev/null");
  EXPECT_NE(error_text([&] {
              write_movie(folder_ / "x.mp4", 24, 3, picture);
            }).find("picture 2 of the film is 4x3"),
            std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "x.mp4"));
}

TEST_F(MovieFile, RealFfmpegWritesBothFormats) {
  setenv("PATH", path_.c_str(), 1);
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "no ffmpeg here";
  for (const char* name : {"odd.mp4", "odd.webm"}) {
    const fs::path file = write_movie(folder_ / name, 12, 5,
                                      [](size_t i) { return grey(33, 17, 0.2F * static_cast<float>(i)); });
    const std::string bytes = read_file(file);
    EXPECT_GT(bytes.size(), 300U);
    EXPECT_NE(bytes.substr(0, 64).find(file.extension() == ".mp4" ? "ftyp" : "webm"), std::string::npos);
  }
}

}  // namespace
}  // namespace ld
