// What ld_denoise refuses before it works, and pictures that there is nothing to denoise in.
#include <gtest/gtest.h>

#include <limits>

#include "core/file_io.h"
#include "frame/frame_file.h"
#include "tests/inference/denoising_test.h"
#include "tests/support/exr_parts.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"

namespace ld {
namespace {

namespace fs = std::filesystem;
const Imath::Box2i kSmallWindow({0, 0}, {11, 8});
constexpr float kNan = std::numeric_limits<float>::quiet_NaN(), kInf = std::numeric_limits<float>::infinity();

class RefusedFirst : public DenoisingTest {
 protected:
  static ProgramResult denoise(std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), {"--model", path("model.safetensors"), "--threads", "1"});
    return run_program("ld_denoise", arguments);
  }
  /// A render of one sample.
  static std::string render(const std::string& name, float value) {
    write_exr_parts(
        path(name), kSmallWindow,
        {{"", kSmallWindow, {{"R", everywhere(value)}, {"G", everywhere(value)}, {"B", everywhere(value)}}}});
    return path(name);
  }
};

TEST_F(RefusedFirst, KernelsOfPixelsThatOneOfTheFramesDoesNotHave) {
  write_frame(path("large.exr"), random_frame(12, 9, 2));
  write_frame(path("small.exr"), random_frame(5, 4, 2));
  const std::string out = path("kernels");
  for (const char* pixel : {"5,3", "4,4", "11,8"})
    expect_failure(denoise({path("large.exr"), path("small.exr"), "--output", out, "--kernel-at", pixel}), 2,
                   {"small.exr", "no pixel", "5 x 4"});
  EXPECT_FALSE(fs::exists(out)) << "the large one has these pixels, but must not be done first";
  for (const char* pixel : {"-1,0", "0,-1", "99999999999,0", "1,2,3", "1", ""})
    expect_failure(
        denoise({path("large.exr"), "--output", path("k.exr"), std::string("--kernel-at=") + pixel}), 2,
        {"--kernel-at", "X,Y"});
  // Renders have their size from their radiance.
  const std::string picture = render("kernel_render.exr", 1);
  expect_failure(denoise({picture, "--output", path("k.exr"), "--kernel-at", "12,0"}), 2,
                 {"kernel_render.exr", "no pixel", "12 x 9"});
  EXPECT_FALSE(fs::exists(path("k.exr")));
  // A file that is not there is complained of in its turn, and the others are done.
  const ProgramResult gap =
      denoise({path("large.exr"), path("none.exr"), "--output", path("gap"), "--kernel-at", "11,8"});
  EXPECT_EQ(gap.exit_code, 1) << gap.output;
  EXPECT_TRUE(fs::exists(path("gap/large.exr")));
}

TEST_F(RefusedFirst, PartsThatAreAskedForTwice) {
  write_frame(path("twice.exr"), random_frame(12, 9, 2));
  const std::string out = path("twice_out.exr");
  expect_failure(denoise({path("twice.exr"), "--output", out, "--kernel-at", "1,2", "--kernel-at", "01,2"}),
                 2, {"--kernel-at", "1,2", "twice"});
  expect_failure(denoise({path("twice.exr"), "--output", out, "--aovs", "layers,unfiltered,layers"}), 2,
                 {"--aovs", "layers", "twice"});
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(RefusedFirst, PicturesOfNothingButNanAndInfinity) {
  Frame frame = random_frame(12, 9, 3);
  for (int s = 0; s < frame.spp; ++s)
    std::fill_n(frame.plane(s, s), frame.plane_size(), s == 1 ? kInf : kNan);
  write_frame(path("nothing.exr"), frame);
  const std::string out = path("nothing_out.exr");
  const std::string text = "every sample of every pixel";
  expect_failure(denoise({path("nothing.exr"), "--output", out, "--noisy", path("noisy.exr")}), 1,
                 {"nothing.exr", text});
  expect_failure(denoise({render("nan.exr", kNan), "--output", out}), 1, {"nan.exr", text});
  expect_failure(denoise({render("inf.exr", kInf), "--output", out}), 1, {"inf.exr", text});
  EXPECT_FALSE(fs::exists(out));
  EXPECT_FALSE(fs::exists(path("noisy.exr")));
  // Where only the samples that are asked for are bad, too.
  frame.plane(2, 2)[5] = 1;
  write_frame(path("last.exr"), frame);
  expect_failure(denoise({path("last.exr"), "--samples", "2", "--output", out}), 1, {"last.exr", text});
  const ProgramResult partly = denoise({path("last.exr"), "--output", out});
  EXPECT_EQ(partly.exit_code, 0) << partly.output;
  EXPECT_NE(partly.output.find("323 samples with NaN or infinity masked out"), std::string::npos)
      << partly.output;
  // As data of a training likewise.
  expect_failure(run_program("ld_import", {"--preset", "mitsuba", "--frame", path("f.exr"), path("nan.exr")}),
                 1, {"nan.exr", text});
  EXPECT_FALSE(fs::exists(path("f.exr")));
  expect_failure(
      run_program("ld_import", {"--preset", "mitsuba", "--out", path("set"), "--name", "a", "--split",
                                "train", "--reference", path("inf.exr"), render("fine.exr", 1)}),
      1, {"inf.exr"});
  EXPECT_FALSE(fs::exists(path("set")));
}

TEST_F(RefusedFirst, FormerResultsAreNoSamples) {
  fs::create_directory(path("again"));
  render("again/r_1.exr", 1);
  render("again/r_2.exr", 3);
  const std::string pattern = path("again/r_*.exr"), result = path("again/r_denoised.exr");
  ASSERT_EQ(denoise({pattern, "--output", result, "--float"}).exit_code, 0);
  const std::string bytes = read_file(result);
  // The same command, and one with another output, which then is a former result, too.
  for (const std::string& output : {result, path("again/r_0.exr"), path("again/r_3.exr")}) {
    const ProgramResult again = denoise({pattern, "--output", output, "--float"});
    EXPECT_EQ(again.exit_code, 0) << again.output;
    EXPECT_NE(again.output.find("r_denoised.exr: left out"), std::string::npos) << again.output;
    EXPECT_TRUE(read_file(output) == bytes) << output;
  }
  // Names that a shell made of the pattern.
  const ProgramResult named = denoise(
      {path("again/r_1.exr"), path("again/r_2.exr"), result, "--output", path("again/named.exr"), "--float"});
  EXPECT_EQ(named.exit_code, 0) << named.output;
  EXPECT_NE(named.output.find("r_denoised.exr: left out"), std::string::npos) << named.output;
  EXPECT_TRUE(read_file(path("again/named.exr")) == bytes);
  // What is named is not overwritten, left out or not.
  expect_failure(denoise({path("again/r_1.exr"), path("again/r_2.exr"), result, "--output", result}), 2,
                 {"r_denoised.exr is one of the inputs"});
  // Nothing is left.
  const std::string out = path("again/out.exr");
  for (const std::string& input : {result, path("again/r_d*.exr")})
    expect_failure(denoise({input, "--output", out}), 1, {"r_denoised.exr", "denoised already"});
  for (const char* frame : {"1", "2"})
    fs::copy_file(result, path(std::string("again/seq.") + frame + ".exr"));
  const ProgramResult sequence = denoise({path("again/seq.#.exr"), "--output", path("again/seq_out.#.exr")});
  EXPECT_EQ(sequence.exit_code, 1);
  EXPECT_NE(sequence.output.find("seq.1.exr: denoised already"), std::string::npos) << sequence.output;
  expect_failure(
      run_program("ld_import", {"--preset", "mitsuba", "--frame", out, path("again/r_1.exr"), result}), 1,
      {"r_denoised.exr: denoised already"});
  EXPECT_FALSE(fs::exists(out));
}

TEST_F(RefusedFirst, FormerResultsOfOneViewAreSamplesOfTheOther) {
  TestPart part{"rgba", kSmallWindow, {}};
  for (const char* prefix : {"", "right."})
    for (const char* colour : {"R", "G", "B"})
      part.channels.emplace_back(std::string(prefix) + colour, everywhere(prefix[0] == 'r' ? 2.0F : 1.0F));
  write_exr_parts(path("views.exr"), kSmallWindow, {part}, {"left", "right"});
  ASSERT_EQ(denoise({path("views.exr"), "--view", "right", "--output", path("half.exr")}).exit_code, 0);
  expect_failure(denoise({path("half.exr"), "--view", "right", "--output", path("v.exr")}), 1,
                 {"half.exr", "denoised already"});
  ASSERT_EQ(denoise({path("half.exr"), "--output", path("whole.exr")}).exit_code, 0);
  for (const char* view : {"left", "right"}) {
    expect_failure(denoise({path("whole.exr"), "--view", view, "--output", path("v.exr")}), 1,
                   {"whole.exr", "denoised already"});
    expect_failure(
        denoise({path("whole.exr"), "--set", std::string("view=") + view, "--output", path("v.exr")}), 1,
        {"whole.exr", "denoised already"});
  }
  EXPECT_FALSE(fs::exists(path("v.exr")));
  const ProgramResult beside =
      denoise({path("views.exr"), path("half.exr"), "--view", "right", "--output", path("v.exr")});
  EXPECT_EQ(beside.exit_code, 0) << beside.output;
  EXPECT_NE(beside.output.find("half.exr: left out"), std::string::npos) << beside.output;
}

}  // namespace
}  // namespace ld
