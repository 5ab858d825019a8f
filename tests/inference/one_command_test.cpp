// What ld_denoise does for those who name files and nothing else: whose files they are, which weights, which
// samples.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>

#include "frame/exr_reader.h"
#include "frame/frame_file.h"
#include "import/recognise.h"
#include "inference/sequence_names.h"
#include "tests/support/expect_error.h"
#include "tests/support/exr_parts.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"
#include "weights/released.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

TEST(OneCommand, RendersAreRecognisedByTheirChannels) {
  for (const auto& [folder, preset] :
       {std::pair{"cycles", "cycles"}, {"cycles5", "cycles"}, {"mitsuba", "mitsuba"}}) {
    const ExrReader exr(kImportFixtures / folder / "sample_00.exr");
    EXPECT_FALSE(is_frame(exr)) << folder;
    EXPECT_EQ(recognise_preset(exr), preset) << folder;
  }
}

/// A file of one pixel with these channels.
void write_channels(const fs::path& path, const std::vector<std::string>& channels) {
  Imf::Header header(1, 1);
  std::vector<float> values(channels.size(), 0.5F);
  Imf::FrameBuffer buffer;
  for (size_t c = 0; c < channels.size(); ++c) {
    header.channels().insert(channels[c], Imf::Channel(Imf::FLOAT));
    buffer.insert(channels[c], Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&values[c]), 4, 4));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(1);
}

TEST(OneCommand, LayoutsOfWhichNoFileIsAtHandAreToldApart) {
  const TemporaryFolder folder;
  const std::vector<std::string> picture = {"R", "G", "B", "A"}, position = {"P.X", "P.Y", "P.Z"},
                                 normal = {"N.X", "N.Y", "N.Z"};
  const auto preset_of = [&](const std::vector<std::vector<std::string>>& groups) {
    std::vector<std::string> channels;
    for (const auto& group : groups) channels.insert(channels.end(), group.begin(), group.end());
    write_channels(folder / "file.exr", channels);
    return recognise_preset(ExrReader(folder / "file.exr"));
  };
  EXPECT_EQ(
      preset_of({picture, normal, position, {"diffuse_albedo.R", "diffuse_albedo.G", "diffuse_albedo.B"}}),
      "arnold");
  EXPECT_EQ(preset_of({{"R", "G", "B"},
                       normal,
                       position,
                       {"Ns.X", "Ns.Y", "Ns.Z"},
                       {"Albedo.R", "Albedo.G", "Albedo.B"}}),
            "pbrt");
  const std::vector<std::string> albedo = {"albedo.R", "albedo.G", "albedo.B"};
  EXPECT_EQ(preset_of({picture, {"N.x", "N.y", "N.z"}, {"P.x", "P.y", "P.z"}, albedo}), "karma");
  EXPECT_EQ(preset_of({picture, {"hitN.x", "hitN.y", "hitN.z"}, {"hitPz"}, albedo}), "karma");
  EXPECT_EQ(preset_of({picture,
                       {"__Nworld.r", "__Nworld.g", "__Nworld.b"},
                       {"__Pworld.r", "__Pworld.g", "__Pworld.b"},
                       {"albedo.r", "albedo.g", "albedo.b"}}),
            "renderman");
  EXPECT_EQ(preset_of({picture,
                       {"Z", "VRayNormals.X", "VRayNormals.Y", "VRayNormals.Z"},
                       {"VRayDiffuseFilter.R", "VRayDiffuseFilter.G", "VRayDiffuseFilter.B"}}),
            "vray");
  EXPECT_EQ(preset_of({picture, {"Z"}}), "mitsuba") << "Z could be anybody's, and so could R, G, B and A";
}

TEST(OneCommand, FramesAreToldFromRendersAndWhatIsNeitherIsAnError) {
  const TemporaryFolder folder;
  write_frame(folder / "frame.exr", random_frame(5, 4, 2));
  EXPECT_TRUE(is_frame(ExrReader(folder / "frame.exr")));
  write_image(folder / "grey.exr", Image(5, 4, 1));
  EXPECT_ERROR(recognise_preset(ExrReader(folder / "grey.exr")), "the file has Y");
  write_image(folder / "plain.exr", Image(5, 4, 3));
  EXPECT_EQ(recognise_preset(ExrReader(folder / "plain.exr")), "mitsuba");
}

TEST(OneCommand, QuotedPatternsAreTheFilesThatFit) {
  const TemporaryFolder folder;
  for (const char* name : {"b_2.exr", "b_1.exr", "c.exr", "odd[1].exr"})
    write_image(folder / name, Image(1, 1, 3));
  const auto at = [&](const char* name) { return (folder / name).string(); };
  EXPECT_EQ(expand_names({at("b_?.exr"), at("c.exr")}),
            (std::vector<std::string>{at("b_1.exr"), at("b_2.exr"), at("c.exr")}));
  EXPECT_EQ(expand_names({at("odd[1].exr")}), std::vector<std::string>{at("odd[1].exr")})
      << "a file of that name";
  EXPECT_ERROR(expand_names({at("z*.exr")}), "no file fits");
  EXPECT_EQ(first_file({at("b_#.exr")}, {}), at("b_1.exr"));
  EXPECT_EQ(first_file({at("b_#.exr")}, FrameRange{2, 9}), at("b_2.exr"));
  EXPECT_EQ(first_file({at("z_#.exr")}, {}), "");
}

TEST(OneCommand, WeightsAreFoundByName) {
  const std::vector<std::string> names = released_models();
  for (const char* name :
       {"common_fast", "common_fine", "common_small", "common_tiny", "history_fast", "means", "pyramid_fine"})
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  EXPECT_EQ(resolve_model("common").filename(), "common_fine.safetensors");
  EXPECT_EQ(read_weights_header(SafetensorsFile(resolve_model("means"))).network.means, true);
  EXPECT_ERROR(resolve_model("comon"), "one of the released common_fast, common_fine");
}

TEST(OneCommand, SamplesOfOneFrameBecomeAPicture) {
  const TemporaryFolder folder;
  const std::string output = (folder / "denoised.exr").string();
  for (const char* renderer : {"cycles", "mitsuba"}) {
    const ProgramResult result = run_program(
        "ld_denoise",
        {(kImportFixtures / renderer / "sample_*.exr").string(), "--output", output, "--threads", "1"});
    ASSERT_EQ(result.exit_code, 0) << result.output;
    for (const std::string& text :
         {fmt::format("renders as preset {} has them", renderer), std::string("samples of one frame"),
          std::string("radiance: "), std::string("albedo: "), std::string("normal")})
      EXPECT_NE(result.output.find(text), std::string::npos) << text << "\n" << result.output;
    int64_t bad = -1;
    const Image image = read_image(output, &bad);
    EXPECT_EQ(bad, 0);
    EXPECT_GT(*std::max_element(image.pixels.begin(), image.pixels.end()), 0.1F);
  }
}

TEST(OneCommand, ARenderAloneIsDenoisedByItsMeans) {
  const TemporaryFolder folder;
  const std::string output = (folder / "denoised.exr").string(),
                    input = (kImportFixtures / "cycles/sample_00.exr").string();
  const ProgramResult result = run_program("ld_denoise", {input, "--output", output, "--threads", "1"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("denoised with the model 'means'"), std::string::npos) << result.output;
  EXPECT_NE(result.output.find("normal left out: ViewLayer.Normal.X needs the camera"), std::string::npos)
      << result.output;
  const ProgramResult named =
      run_program("ld_denoise", {input, "--output", output, "--model", "common_fast", "--threads", "1"});
  EXPECT_EQ(named.exit_code, 0) << named.output;
  EXPECT_EQ(named.output.find("'means'"), std::string::npos) << "whoever names weights gets them";
}

TEST(OneCommand, AFilmOfThePicturesOnRequest) {
  const TemporaryFolder folder;
  const std::string output = (folder / "denoised.exr").string(),
                    input = (kImportFixtures / "cycles/sample_00.exr").string();
  const auto run = [&](const std::string& film) {
    RunningProgram program("ld_denoise",
                           {input, "--output", output, "--movie", (folder / film).string(), "--threads", "1"},
                           {{"PATH", "/nowhere"}});
    const int code = program.wait();
    return ProgramResult{code, program.output()};
  };
  expect_failure(run("film.avi"), 2, {"--movie", "film.avi", "expected .mp4 or .webm"});
  EXPECT_FALSE(std::filesystem::exists(output));
  const ProgramResult result = run("film.webm");
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("no program ffmpeg"), std::string::npos) << result.output;
  const std::filesystem::path picture = folder / "film/000000.png";
  EXPECT_EQ(read_file(picture), png_bytes(picture, read_image(output)));
}

}  // namespace
}  // namespace ld
