// Frames of other programs through ld_denoise: where pictures lie, what is kept, what is said, what is never
// overwritten.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <limits>

#include "core/file_io.h"
#include "frame/exr_reader.h"
#include "frame/frame_file.h"
#include "inference/denoise_job.h"
#include "tests/inference/denoising_test.h"
#include "tests/support/expect_error.h"
#include "tests/support/exr_parts.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"

namespace ld {
namespace {

namespace fs = std::filesystem;
const Imath::Box2i kDisplay({0, 0}, {29, 19}), kSamples({5, 4}, {16, 12});

TestPart colour_part(const std::string& name, const Imath::Box2i& window, float value) {
  return {
      name, window, {{"R", everywhere(value)}, {"G", everywhere(value / 2)}, {"B", everywhere(value / 4)}}};
}

class ForeignFrames : public DenoisingTest {
 protected:
  static void denoise(const std::string& input, const std::string& output, bool full_float = false) {
    DenoiseJob job;
    job.model = path("model.safetensors");
    job.tasks = plan_tasks({path(input)}, path(output), {}, false);
    job.full_float = full_float;
    run_denoise_job(job);
  }
  static ProgramResult run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {"--model", path("model.safetensors")});
    return run_program("ld_denoise", arguments);
  }
};

TEST_F(ForeignFrames, ThePictureLiesWhereTheSamplesDoAndTheMeansChannelsAreMovedThere) {
  for (const Imath::Box2i& mean :
       {kSamples, kDisplay, Imath::Box2i({0, 0}, {11, 8}), Imath::Box2i({-3, 10}, {6, 30})}) {
    TestPart first = colour_part("mean", mean, 1);
    first.channels.emplace_back("crypto", [](int x, int y) { return float(x + 100 * y); });
    write_exr_parts(path("mean.exr"), kDisplay,
                    {first, colour_part("s000", kSamples, 1), colour_part("s001", kSamples, 1)});
    denoise("mean.exr", "moved.exr", true);
    const ExrReader exr(path("moved.exr"));
    EXPECT_EQ(exr.parts(), 1);
    EXPECT_EQ(exr.header(0).dataWindow(), kSamples);
    EXPECT_EQ(exr.header(0).displayWindow(), kDisplay);
    const std::vector<float> crypto = channel_of(exr, 0, "crypto");
    for (int y = kSamples.min.y; y <= kSamples.max.y; ++y)
      for (int x = kSamples.min.x; x <= kSamples.max.x; ++x)
        ASSERT_EQ(crypto[size_t((y - kSamples.min.y) * exr.width(0) + x - kSamples.min.x)],
                  mean.intersects(Imath::V2i(x, y)) ? float(x + 100 * y) : 0.0F)
            << x << " " << y;
    for (const float red : channel_of(exr, 0, "R")) ASSERT_NEAR(red, 1, 1e-5);
  }
}

TEST_F(ForeignFrames, PartsThatAreNoSamplesAndAlphaOfTheMeanAloneAreKept) {
  TestPart mean = colour_part("mean", kSamples, 1);
  mean.channels.emplace_back("A", [](int x, int) { return float(x) / 32; });
  const TestPart crypto{"crypto",
                        Imath::Box2i({2, 1}, {9, 9}),
                        {{"id", [](int x, int y) { return 1e-30F * float(x + 50 * y); }}}};
  write_exr_parts(path("parts.exr"), kDisplay,
                  {mean, crypto, colour_part("s000", kSamples, 1), colour_part("s001", kSamples, 1),
                   colour_part("denoised", kSamples, 7)});
  denoise("parts.exr", "kept.exr");
  const ExrReader exr(path("kept.exr"));
  EXPECT_EQ(exr.parts(), 3);
  EXPECT_EQ(exr.channel_list(0), "A, B, G, R");
  const std::vector<float> alpha = channel_of(exr, 0, "A");
  EXPECT_EQ(alpha[3], 8.0F / 32);
  const int kept = part_of(exr, "crypto");
  ASSERT_GE(kept, 0);
  EXPECT_EQ(exr.header(kept).dataWindow(), crypto.window);
  EXPECT_EQ(channel_of(exr, kept, "id")[8], 1e-30F * 102);
  const int old = part_of(exr, "denoised_");
  ASSERT_GE(old, 0) << "a picture that was denoised before";
  EXPECT_EQ(channel_of(exr, old, "R")[0], 7.0F);
}

TEST_F(ForeignFrames, ABadGuideCostsTheGuideAlone) {
  Frame good = random_frame(9, 7, 3), bad = good;
  for (size_t p = 0; p < good.plane_size(); ++p) {
    bad.plane(1, kNormalOffset)[p] = std::numeric_limits<float>::quiet_NaN();
    bad.plane(2, kDepthOffset)[p] = std::numeric_limits<float>::infinity();
    for (int c = 0; c < 3; ++c) good.plane(1, kNormalOffset + c)[p] = 0;
    good.plane(2, kDepthOffset)[p] = kEscapedDepth;
  }
  bad.info.depth_scale = good.info.depth_scale = 2;
  write_frame(path("bad.exr"), bad);
  write_frame(path("good.exr"), good);
  const ProgramResult result = run({path("bad.exr"), "--output", path("bad_out.exr")});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("126 guides of samples that are NaN or infinite"), std::string::npos)
      << result.output;
  denoise("good.exr", "good_out.exr");
  EXPECT_EQ(read_image(path("bad_out.exr")).pixels, read_image(path("good_out.exr")).pixels);
}

TEST_F(ForeignFrames, ColoursBeyondHalfKeepTheirHueAndAreCounted) {
  write_exr_parts(path("bright.exr"), kDisplay,
                  {colour_part("s000", kSamples, 400000), colour_part("s001", kSamples, 400000)});
  const ProgramResult half = run({path("bright.exr"), "--output", path("half.exr")});
  EXPECT_NE(half.output.find("324 colour channels are brighter than half floats reach"), std::string::npos)
      << half.output;
  EXPECT_NE(half.output.find("--float keeps them"), std::string::npos) << half.output;
  const ExrReader exr(path("half.exr"));
  EXPECT_EQ(channel_of(exr, 0, "R")[5], 65504.0F);
  EXPECT_NEAR(channel_of(exr, 0, "G")[5], 32752, 32);
  EXPECT_NEAR(channel_of(exr, 0, "B")[5], 16376, 16);
  const ProgramResult full = run({"--float", path("bright.exr"), "--output", path("full.exr")});
  EXPECT_EQ(full.output.find("half floats"), std::string::npos) << full.output;
  EXPECT_NEAR(channel_of(ExrReader(path("full.exr")), 0, "R")[5], 400000, 4);
}

TEST_F(ForeignFrames, NoOutputReplacesAnInputWhateverItIsCalled) {
  fs::create_directories(path("there/below"));
  write_frame(path("there/in.exr"), random_frame(4, 3, 2));
  const std::string bytes = read_file(path("there/in.exr"));
  fs::create_directory_symlink(path("there"), path("linked"));
  fs::create_hard_link(path("there/in.exr"), path("hard.exr"));
  fs::create_symlink(path("there/in.exr"), path("soft.exr"));
  for (const char* output :
       {"there/in.exr", "there/below/../in.exr", "linked/in.exr", "hard.exr", "soft.exr"}) {
    expect_failure(run({path("there/in.exr"), "--output", path(output)}), 2, {"in.exr"});
    expect_failure(run({path("there/in.exr"), "--output", path("x.exr"), "--json", path(output)}), 2,
                   {"in.exr"});
  }
  expect_failure(run({path("there/in.exr"), "--output", path("model.safetensors")}), 2,
                 {"model.safetensors"});
  expect_failure(
      run_program("ld_import", {"--preset", "cycles", "--frame", path("hard.exr"), path("there/in.exr")}), 2,
      {"is the input"});
  expect_failure(run_program("ld_export", {"--model", path("model.safetensors"), "--format", "safetensors",
                                           "--out", path("linked/../model.safetensors")}),
                 2, {"model.safetensors"});
  EXPECT_EQ(read_file(path("there/in.exr")), bytes);
  EXPECT_FALSE(fs::exists(path("x.exr")));
}

TEST_F(ForeignFrames, OptionsTakeOneValueInAnyOrder) {
  write_frame(path("order.exr"), random_frame(4, 3, 2));
  for (const std::vector<std::string>& option : {std::vector<std::string>{"--kernel-at", "1,1"},
                                                 {"--aovs", "layers"},
                                                 {"--kernel-at", "1,1", "--aovs", "layers,unfiltered"}}) {
    std::vector<std::string> arguments = option;
    arguments.insert(arguments.end(), {path("order.exr"), "--output", path("order_out.exr")});
    const ProgramResult result = run(arguments);
    EXPECT_EQ(result.exit_code, 0) << result.output;
  }
  expect_failure(run({"--set", "layer=L", path("order.exr"), "--output", path("order_out.exr")}), 2,
                 {"--set", "is a frame"});
}

TEST_F(ForeignFrames, TwoOutputsAreNeverOneFile) {
  write_frame(path("pair.exr"), random_frame(4, 3, 2));
  const std::string out = path("pair_out.exr");
  expect_failure(run({path("pair.exr"), "--output", out, "--json", out}), 2, {"are one file; expected two"});
  EXPECT_FALSE(fs::exists(out));
  expect_failure(
      run_program("ld_export", {"--model", path("model.safetensors"), "--format", "safetensors", "--out",
                                path("m.safetensors"), "--check-data", path("m.safetensors")}),
      2, {"are one file; expected two"});
  EXPECT_FALSE(fs::exists(path("m.safetensors")));
}

TEST_F(ForeignFrames, PipesAreNeitherReadNorReplaced) {
  write_frame(path("piped.exr"), random_frame(4, 3, 2));
  ASSERT_EQ(mkfifo(path("pipe.exr").c_str(), 0600), 0);
  expect_failure(run({path("pipe.exr"), "--output", path("piped_out.exr")}), 1, {"is no regular file"});
  expect_failure(run({path("piped.exr"), "--output", path("pipe.exr")}), 1, {"neither a file nor the name"});
  EXPECT_TRUE(fs::is_fifo(path("pipe.exr")));
  EXPECT_EQ(run({path("piped.exr"), "--output", path("piped_out.exr"), "--json", "/dev/null"}).exit_code, 0);
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(ForeignFrames, ALinkThatIsTheOutputIsFollowed) {
  write_frame(path("linked_in.exr"), random_frame(4, 3, 2));
  write_file_atomically(path("real.exr"), "old");
  fs::create_symlink("real.exr", path("link.exr"));
  EXPECT_EQ(run({path("linked_in.exr"), "--output", path("link.exr")}).exit_code, 0);
  EXPECT_TRUE(fs::is_symlink(path("link.exr")));
  EXPECT_NE(read_file(path("real.exr")), "old");
}

TEST_F(ForeignFrames, EmptyFilesAndFoldersAreNoFinishedPictures) {
  fs::create_directory(path("farm"));
  for (const char* name : {"shot.0001.exr", "shot.0002.exr"})
    write_frame(path(std::string("farm/") + name), random_frame(4, 3, 2));
  write_file_atomically(path("farm/out.0001.exr"), "");
  const ProgramResult result =
      run({path("farm/shot.####.exr"), "--output", path("farm/out.####.exr"), "--skip-existing"});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_GT(fs::file_size(path("farm/out.0001.exr")), 0);
}

TEST_F(ForeignFrames, RendersOfAShotAreNotSmearedIntoOnePicture) {
  fs::create_directory(path("shot"));
  for (const int frame : {1, 2})
    write_exr_parts(path("shot/a" + std::to_string(frame) + ".exr"), kDisplay,
                    {colour_part("", kDisplay, float(frame))});
  expect_failure(run({path("shot/a1.exr"), path("shot/a2.exr"), "--output", path("shot")}), 2,
                 {"one picture, but the output", "####"});
}

TEST_F(ForeignFrames, PartsThatAreCroppedArePlaced) {
  for (const bool cropped : {false, true}) {
    const TestPart beauty = colour_part("rgba", kSamples, 1);
    TestPart aux{"aux", cropped ? Imath::Box2i({7, 6}, {9, 8}) : kSamples, {}};
    for (const char* colour : {"R", "G", "B"})
      aux.channels.emplace_back(std::string("albedo.") + colour, everywhere(0.5F));
    write_exr_parts(path("cropped.exr"), kDisplay, {beauty, aux});
    const ProgramResult result = run({path("cropped.exr"), "--output", path("cropped_out.exr"), "--float"});
    EXPECT_EQ(result.exit_code, 0) << result.output;
    EXPECT_EQ(result.output.find("albedo: its data window") != std::string::npos, cropped) << result.output;
    const ExrReader exr(path("cropped_out.exr"));
    EXPECT_EQ(exr.header(0).dataWindow(), kSamples);
    EXPECT_EQ(exr.header(part_of(exr, "aux")).dataWindow(), aux.window) << "kept as it is";
    for (const float red : channel_of(exr, 0, "R")) ASSERT_NEAR(red, 1, 1e-5);
  }
}

TEST_F(ForeignFrames, LayersAreNamedWithoutAPreset) {
  TestPart part{"", kDisplay, {}};
  for (const char* layer : {"Front", "Back"})
    for (const char* colour : {"R", "G", "B"})
      part.channels.emplace_back(std::string(layer) + ".Combined." + colour,
                                 everywhere(layer[0] == 'F' ? 1.0F : 2.0F));
  write_exr_parts(path("two_layers.exr"), kDisplay, {part});
  const ProgramResult result =
      run({path("two_layers.exr"), "--set", "layer=Back", "--output", path("back.exr"), "--float"});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NEAR(channel_of(ExrReader(path("back.exr")), 0, "R")[0], 2, 1e-5);
}

TEST_F(ForeignFrames, WhatCannotBeWrittenIsRefusedBeforeTheWork) {
  write_frame(path("late.exr"), random_frame(4, 3, 2));
  expect_failure(run({path("late.exr"), "--output", path("late.jpg")}), 2, {"unknown extension '.jpg'"});
  expect_failure(run({path("late.exr"), "--output", path("late.png"), "--float"}), 2,
                 {"--float goes with EXR"});
  EXPECT_EQ(run({path("late.exr"), "--output", path("LATE.EXR")}).exit_code, 0);
  const std::string longest(251, 'n'), longer(252, 'n');
  EXPECT_EQ(run({path("late.exr"), "--output", path(longest + ".exr")}).exit_code, 0);
  expect_failure(run({path("late.exr"), "--output", path(longer + ".exr")}), 1, {"File name too long"});
}

}  // namespace
}  // namespace ld
