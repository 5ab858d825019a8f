// Stereo and multi-view files through ld_denoise: the view that is asked for is denoised, and of the others
// nothing is lost.
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include "frame/exr_reader.h"
#include "frame/frame_file.h"
#include "import/recognise.h"
#include "tests/inference/denoising_test.h"
#include "tests/support/exr_parts.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"

namespace ld {
namespace {

namespace fs = std::filesystem;
const Imath::Box2i kWindow({0, 0}, {7, 5});

/// Pictures are written as half floats; what is kept stays full floats, as the files of these tests have
/// them.
void expect_channel(const ExrReader& exr, int part, const std::string& name, bool denoised, float value) {
  const Imf::Channel* channel = exr.header(part).channels().findChannel(name);
  ASSERT_NE(channel, nullptr) << name << " of " << exr.channel_list(part);
  EXPECT_EQ(channel->type, denoised ? Imf::HALF : Imf::FLOAT) << name;
  std::vector<float> pixels(size_t(exr.width(part)) * size_t(exr.height(part)));
  exr.read(part, {{name, pixels.data(), pixels.size()}});
  for (const float pixel : pixels) ASSERT_NEAR(pixel, value, 1e-3F * value) << name;
}

class Stereo : public DenoisingTest {
 protected:
  static ProgramResult denoise(const std::string& input, const std::string& output,
                               const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"--model", path("model.safetensors"), "--threads", "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    arguments.insert(arguments.end(), {path(input), "--output", path(output)});
    return run_program("ld_denoise", arguments);
  }

  static void write_one_part() {
    TestChannels channels = colour("", 1);
    for (const TestChannels& more :
         {colour("right.", 2), colour("albedo.", 0.25F), colour("albedo.right.", 0.5F)})
      channels.insert(channels.end(), more.begin(), more.end());
    write_exr_parts(path("one.exr"), kWindow, {{"rgba", kWindow, channels}}, {"left", "right"});
  }
};

TEST_F(Stereo, TheHeroOfOnePart) {
  write_one_part();
  const ProgramResult result = denoise("one.exr", "hero.exr");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("view: left, of left, right; --view NAME takes another"), std::string::npos)
      << result.output;
  const ExrReader exr(path("hero.exr"));
  EXPECT_EQ(exr.parts(), 1);
  expect_channel(exr, 0, "R", true, 1);
  expect_channel(exr, 0, "right.R", false, 2);
  expect_channel(exr, 0, "albedo.G", false, 0.25F);
  expect_channel(exr, 0, "albedo.right.G", false, 0.5F);
  EXPECT_EQ(Imf::multiView(exr.header(0)), (Imf::StringVector{"left", "right"}));
}

TEST_F(Stereo, AnotherViewOfOnePartAndThenTheHero) {
  write_one_part();
  ASSERT_EQ(denoise("one.exr", "right.exr", {"--view", "right"}).exit_code, 0);
  const ExrReader right(path("right.exr"));
  expect_channel(right, 0, "R", false, 1);
  expect_channel(right, 0, "right.R", true, 2);
  ASSERT_EQ(denoise("right.exr", "both.exr").exit_code, 0);
  const ExrReader both(path("both.exr"));
  expect_channel(both, 0, "R", true, 1);
  expect_channel(both, 0, "right.R", true, 2);
  expect_channel(both, 0, "albedo.right.B", false, 0.5F);
}

TEST_F(Stereo, ViewsInParts) {
  write_exr_parts(path("parts.exr"), kWindow,
                  {{"rgb.left", kWindow, colour("", 1), "left"},
                   {"rgb.right", kWindow, colour("", 2), "right"},
                   {"matte", kWindow, {{"id", everywhere(7)}}}});
  ASSERT_EQ(denoise("parts.exr", "left.exr").exit_code, 0);
  ASSERT_EQ(denoise("parts.exr", "right.exr", {"--view", "right"}).exit_code, 0);
  const ExrReader left(path("left.exr")), right(path("right.exr"));
  EXPECT_EQ(left.header(0).view(), "left");
  expect_channel(left, 0, "R", true, 1);
  expect_channel(left, part_of(left, "rgb.right"), "R", false, 2);
  EXPECT_EQ(right.header(0).view(), "left") << "the hero stays the hero";
  expect_channel(right, 0, "R", false, 1);
  ASSERT_EQ(right.part_name(1), "denoised");
  EXPECT_EQ(right.header(1).view(), "right");
  expect_channel(right, 1, "R", true, 2);

  // The other view afterwards, in either order.
  ASSERT_EQ(denoise("left.exr", "left_right.exr", {"--view", "right"}).exit_code, 0);
  ASSERT_EQ(denoise("right.exr", "right_left.exr").exit_code, 0);
  for (const char* name : {"left_right.exr", "right_left.exr"}) {
    const ExrReader both(path(name));
    ASSERT_EQ(both.parts(), 3) << name;
    EXPECT_EQ(both.header(0).view(), "left") << name;
    expect_channel(both, 0, "R", true, 1);
    EXPECT_EQ(both.header(1).view(), "right") << name;
    expect_channel(both, 1, "R", true, 2);
    expect_channel(both, part_of(both, "matte"), "id", false, 7);
  }
}

TEST_F(Stereo, BlendersFiles) {
  for (const char* folder : {"cycles", "cycles5"}) {
    const fs::path input = kImportFixtures / folder / "stereo.exr";
    for (const char* view : {"left", "right"}) {
      const std::string output = path(fmt::format("{}_{}.exr", folder, view));
      const ProgramResult result =
          run_program("ld_denoise", {input.string(), "--view", view, "--output", output, "--threads", "1",
                                     "--camera", (kImportFixtures / "cycles/camera.yaml").string()});
      ASSERT_EQ(result.exit_code, 0) << result.output;
      // All channels of the other view, in as many parts as before.
      const ExrReader before(input), after(output);
      EXPECT_EQ(after.parts(), before.parts());
      const std::string other = std::string(view) == "left" ? "right" : "left";
      int kept = 0;
      for (int part = 0; part < after.parts(); ++part)
        for (auto it = after.header(part).channels().begin(); it != after.header(part).channels().end(); ++it)
          if (before.parts() == 1 ? std::string(it.name()).find("." + other + ".") != std::string::npos
                                  : after.header(part).view() == other)
            ++kept;
      EXPECT_EQ(kept, 4 + 1 + 3 + 3 + 3 + 4) << "Combined, Depth, Normal, DiffCol, GlossCol, Vector";
    }
  }
}

TEST_F(Stereo, ViewsThatAreNotThere) {
  write_one_part();
  expect_failure(denoise("one.exr", "none.exr", {"--view", "middle"}), 2,
                 {"no view 'middle'", "left, right"});
  expect_failure(run_program("ld_import", {"--preset", "mitsuba", "--frame", path("none.exr"),
                                           path("one.exr"), "--view", "middle"}),
                 2, {"no view 'middle'", "left, right"});
  write_frame(path("frame.exr"), random_frame(4, 3, 2));
  expect_failure(denoise("frame.exr", "none.exr", {"--view", "left"}), 2, {"--view", "is a frame"});
  EXPECT_FALSE(fs::exists(path("none.exr")));
}

TEST_F(Stereo, ImportedFramesSayWhichViewTheyAre) {
  write_one_part();
  const ProgramResult result = run_program("ld_import", {"--preset", "mitsuba", path("one.exr"), "--view",
                                                         "right", "--frame", path("right_frame.exr")});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("view: right, of left, right"), std::string::npos) << result.output;
  EXPECT_TRUE(is_frame(ExrReader(path("right_frame.exr"))));
}

TEST_F(Stereo, ChannelsMakeWayForThePicture) {
  TestChannels channels = colour("ViewLayer.Combined.", 2);
  channels.emplace_back("R", everywhere(3));
  write_exr_parts(path("taken.exr"), kWindow, {{"rgba", kWindow, channels}});
  const ProgramResult result = denoise("taken.exr", "way.exr");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("is kept as 'input.R'"), std::string::npos) << result.output;
  const ExrReader exr(path("way.exr"));
  expect_channel(exr, 0, "R", true, 2);
  expect_channel(exr, 0, "input.R", false, 3);
}

}  // namespace
}  // namespace ld
