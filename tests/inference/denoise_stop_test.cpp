// ld_denoise that is stopped leaves whole files only and says in one line what is done.
#include <gtest/gtest.h>

#include <thread>

#include "frame/frame_file.h"
#include "tests/models/small_network.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"
#include "weights/model_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

class StoppedDenoising : public ::testing::Test {
 protected:
  StoppedDenoising() {
    save_network(path("layer.safetensors"), *small_network(small_config(), torch::kFloat32), "{}",
                 DType::f32);
    write_frame(path("in.0001.exr"), random_frame(12, 9, 2));
  }
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  TemporaryFolder folder_;
};

TEST_F(StoppedDenoising, StopsBetweenWholeFiles) {
  fs::create_directory(path("many"));
  std::vector<std::string> arguments = {"--output", path("stopped")};
  for (int i = 0; i < 400; ++i) {
    arguments.push_back(path(fmt::format("many/{:03}.exr", i)));
    fs::create_hard_link(path("in.0001.exr"), arguments.back());
  }
  arguments.insert(arguments.begin(), {"--model", path("layer.safetensors")});
  RunningProgram program("ld_denoise", arguments);
  for (int waited = 0; waited < 20000 && !fs::exists(path("stopped/000.exr")); ++waited)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  program.signal(SIGTERM);
  EXPECT_EQ(program.wait(), 143) << program.output();
  size_t written = 0;
  for (const auto& entry : fs::directory_iterator(path("stopped"))) {
    EXPECT_EQ(entry.path().extension(), ".exr") << entry.path() << " was left behind";
    EXPECT_EQ(read_file(entry.path()), read_file(path("stopped/000.exr")));
    ++written;
  }
  EXPECT_GE(written, 1u);
  EXPECT_LT(written, 400u);
  EXPECT_NE(program.output().find(fmt::format(
                "stopped: {} of 400 pictures are done, the others are not; --skip-existing", written)),
            std::string::npos)
      << program.output();
}

TEST_F(StoppedDenoising, StoppedWithinAPictureItSaysThatNothingIsWritten) {
  Frame large = random_frame(1600, 1200, 1);
  large.features = {"radiance", "normal", "depth"};
  write_frame(path("large.exr"), large);
  // Before the program listens, Ctrl-C just ends it: then it is given more time.
  int code = -SIGINT;
  for (int milliseconds = 100; code == -SIGINT && milliseconds < 10000; milliseconds *= 2) {
    RunningProgram program("ld_denoise", {"--model", path("layer.safetensors"), path("large.exr"), "--output",
                                          path("large_out.exr")});
    std::this_thread::sleep_for(std::chrono::milliseconds(milliseconds));
    program.signal(SIGINT);
    code = program.wait();
    if (code == -SIGINT) continue;
    EXPECT_EQ(code, 130) << program.output();
    EXPECT_NE(program.output().find("stopped before " + path("large.exr") +
                                    " was denoised: " + path("large_out.exr") + " is not written"),
              std::string::npos)
        << program.output();
  }
  EXPECT_EQ(code, 130);
  EXPECT_FALSE(fs::exists(path("large_out.exr")));
  for (const auto& entry : fs::directory_iterator(fs::path(path("large.exr")).parent_path()))
    EXPECT_EQ(entry.path().string().find("partial"), std::string::npos) << entry.path();
}

}  // namespace
}  // namespace ld
