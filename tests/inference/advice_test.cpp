// Who follows what a message advises gets on.
#include <gtest/gtest.h>

#include "core/file_io.h"
#include "frame/frame_file.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"
#include "tests/support/exr_parts.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"
#include "weights/model_file.h"

namespace ld {
namespace {

const Imath::Box2i kAdviceWindow({0, 0}, {7, 5});

class Advice : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string weights(const std::string& name, const std::vector<std::string>& features) const {
    NetworkConfig config = small_config();
    config.features = features;
    save_network(path(name), *small_network(config, torch::kFloat32), "{}", DType::f32);
    return path(name);
  }

  /// A render with the channels, each of the value of the pixel's place and the seed.
  std::string render(const std::string& name, const std::vector<std::string>& channels, int seed = 1) const {
    TestPart part{"", kAdviceWindow, {}};
    for (const std::string& channel : channels)
      part.channels.emplace_back(channel, [seed](int x, int y) { return float(1 + x * seed + y) / 16; });
    write_exr_parts(path(name), kAdviceWindow, {part});
    return path(name);
  }

  /// Fails with `exit_code` and a message that holds `advice`; with `more` on the command line it does not.
  static void expect_advice(const std::string& program, std::vector<std::string> arguments, int exit_code,
                            const std::string& advice, const std::vector<std::string>& more) {
    const ProgramResult refused = run_program(program, arguments);
    EXPECT_EQ(refused.exit_code, exit_code) << refused.output;
    EXPECT_NE(refused.output.find(advice), std::string::npos) << refused.output;
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult followed = run_program(program, arguments);
    EXPECT_EQ(followed.exit_code, 0) << followed.output;
  }

  TemporaryFolder folder_;
};

TEST_F(Advice, ChannelsThatNoFeatureTookAreNamed) {
  const std::string input = render("old.exr", {"R", "G", "B", "Nsx", "Nsy", "Nsz"});
  expect_advice("ld_denoise",
                {"--model", weights("rn.safetensors", {"radiance", "normal"}), "--preset", "pbrt", input,
                 "--output", path("out.exr")},
                1, "--set normal.channels=[...]", {"--set", "normal.channels=[Nsx, Nsy, Nsz]"});
}

TEST_F(Advice, HalfAFeatureIsLeftOut) {
  const std::string input = render("half.exr", {"R", "G", "B", "albedo.R"});
  expect_advice("ld_import", {"--preset", "mitsuba", "--frame", path("f.exr"), input}, 1,
                "--set albedo.channels=[]", {"--set", "albedo.channels=[]"});
}

TEST_F(Advice, OneOfTwoLayersIsNamed) {
  const std::string input = render("layers.exr", {"Front.Combined.R", "Front.Combined.G", "Front.Combined.B",
                                                  "Back.Combined.R", "Back.Combined.G", "Back.Combined.B"});
  expect_advice("ld_import", {"--preset", "cycles", "--frame", path("f.exr"), input}, 1, "--set layer=NAME",
                {"--set", "layer=Back"});
}

TEST_F(Advice, EqualSamplesAreLetThrough) {
  const std::string one = render("one.exr", {"R", "G", "B"}), two = render("two.exr", {"R", "G", "B"});
  expect_advice("ld_import", {"--preset", "mitsuba", "--frame", path("f.exr"), one, two}, 1,
                "--allow-identical", {"--allow-identical"});
}

TEST_F(Advice, FeaturesThatNeedTheCameraGetItOrAreLeftOut) {
  const std::string input = render("position.exr", {"R", "G", "B", "position.X", "position.Y", "position.Z"});
  const std::vector<std::string> command = {"--preset", "mitsuba", "--frame", path("f.exr"), input};
  write_file_atomically(path("camera.yaml"),
                        "position: [0, 0, 5]\nlook_at: [0, 0, 0]\nup: [0, 1, 0]\nfov_y: 0.7\n");
  expect_advice("ld_import", command, 2, "--set depth.channels=[]", {"--set", "depth.channels=[]"});
  expect_advice("ld_import", command, 2, "--camera FILE.yaml", {"--camera", path("camera.yaml")});
}

TEST_F(Advice, APictureWithoutSamplesIsReadAsARender) {
  const std::string input = render("mean.exr", {"R", "G", "B"});
  const std::string model = weights("r.safetensors", {"radiance"});
  const ProgramResult result =
      run_program("ld_denoise", {"--model", model, input, "--output", path("out.exr")});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("one picture a frame"), std::string::npos) << result.output;
  EXPECT_EQ(read_image(path("out.exr")).width, 8);
}

TEST_F(Advice, WhatIsLeftOfASequenceIsDoneBySkipExisting) {
  const std::string model = weights("r.safetensors", {"radiance"});
  write_frame(path("shot.0001.exr"), random_frame(8, 6, 2));
  write_file_atomically(path("shot.0002.exr"), "no picture");
  const std::vector<std::string> command = {"--model", model, path("shot.####.exr"), "--output",
                                            path("out.####.exr")};
  const ProgramResult failed = run_program("ld_denoise", command);
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_NE(failed.output.find("--skip-existing"), std::string::npos) << failed.output;
  write_frame(path("shot.0002.exr"), random_frame(8, 6, 2));
  std::vector<std::string> again = command;
  again.push_back("--skip-existing");
  const ProgramResult done = run_program("ld_denoise", again);
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_EQ(done.output.find("shot.0001.exr (8x6"), std::string::npos) << done.output;
}

}  // namespace
}  // namespace ld
