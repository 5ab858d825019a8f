// ld_denoise --also and --alpha, on a series of files as Cycles writes them and on the frame that they make.
#include <cmath>
#include <nlohmann/json.hpp>

#include "core/file_io.h"
#include "frame/frame_file.h"
#include "tests/inference/denoising_test.h"
#include "tests/support/cycles_passes.h"
#include "tests/support/run_program.h"

namespace ld {
namespace {

const std::vector<std::string> kSurfaces = {"diffuse", "glossy", "transmission", "emitted", "environment"};

class AlsoParts : public DenoisingTest {
 protected:
  static void SetUpTestSuite() {
    DenoisingTest::SetUpTestSuite();
    for (uint32_t s = 0; s < 4; ++s)
      write_cycles_passes(path("sample_" + std::to_string(s) + ".exr"), 21, 15, 40 + s);
  }

  static ProgramResult denoise(const std::string& output, std::vector<std::string> arguments,
                               const std::vector<std::string>& inputs = {path("sample_*.exr")}) {
    arguments.insert(arguments.begin(), {"--model", path("model.safetensors"), "--output", path(output)});
    arguments.insert(arguments.end(), inputs.begin(), inputs.end());
    return run_program("ld_denoise", arguments);
  }
  static std::vector<std::string> also(const std::vector<std::string>& names) {
    std::vector<std::string> arguments = {"--float"};
    for (const std::string& name : names) arguments.insert(arguments.end(), {"--also", name});
    return arguments;
  }
  static void expect_sum(const std::string& file, const std::vector<std::string>& layers, double tolerance) {
    const ExrReader exr(path(file));
    for (const char c : {'R', 'G', 'B'}) {
      const std::vector<float> whole = channel_of(exr, 0, std::string(1, c));
      std::vector<double> sum(whole.size());
      for (const std::string& layer : layers) {
        const std::vector<float> part = channel_of(exr, 0, layer + "." + c);
        EXPECT_GT(*std::max_element(part.begin(), part.end()), 0) << layer;
        for (size_t p = 0; p < sum.size(); ++p) sum[p] += double(part[p]);
      }
      const double largest = double(*std::max_element(whole.begin(), whole.end()));
      for (size_t p = 0; p < sum.size(); ++p) ASSERT_NEAR(sum[p], double(whole[p]), tolerance * largest);
    }
  }
};

TEST_F(AlsoParts, OfRendersSumToThePictureThatIsTheSameWithoutThem) {
  const ProgramResult done = denoise("parts.exr", also(kSurfaces));
  ASSERT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("glossy: ViewLayer.GlossDir * ViewLayer.GlossCol + ViewLayer.GlossInd"),
            std::string::npos)
      << done.output;
  expect_sum("parts.exr", kSurfaces, 1e-5);
  ASSERT_EQ(denoise("groups.exr", also({"light_*"})).exit_code, 0);
  expect_sum("groups.exr", {"light_key", "light_rim light"}, 1e-5);
  ASSERT_EQ(denoise("plain.exr", {"--float"}).exit_code, 0);
  for (const char* c : {"R", "G", "B", "A"})
    for (const char* file : {"parts.exr", "groups.exr"})
      EXPECT_EQ(channel_of(ExrReader(path(file)), 0, c), channel_of(ExrReader(path("plain.exr")), 0, c));
}

TEST_F(AlsoParts, OfAnImportedFrameSumAsFarAsHalfFloatsDo) {
  std::vector<std::string> arguments = {"--preset",        "cycles", "--frame",
                                        path("frame.exr"), "--also", "[deglt]*"};
  for (int s = 0; s < 4; ++s) arguments.push_back(path("sample_" + std::to_string(s) + ".exr"));
  const ProgramResult imported = run_program("ld_import", arguments);
  ASSERT_EQ(imported.exit_code, 0) << imported.output;
  const ProgramResult done = denoise("of_frame.exr", also(kSurfaces), {path("frame.exr")});
  ASSERT_EQ(done.exit_code, 0) << done.output;
  expect_sum("of_frame.exr", kSurfaces, 1e-3);
}

TEST_F(AlsoParts, AlphaIsCopiedOrFiltered) {
  ASSERT_EQ(denoise("copied.exr", {"--float", "--alpha", "copy"}).exit_code, 0);
  ASSERT_EQ(denoise("filtered.exr", {"--float", "--alpha", "filter"}).exit_code, 0);
  const std::vector<float> copied = channel_of(ExrReader(path("copied.exr")), 0, "A"),
                           filtered = channel_of(ExrReader(path("filtered.exr")), 0, "A");
  const auto variance = [](const std::vector<float>& values) {
    double sum = 0, squares = 0;
    for (const float v : values) sum += double(v), squares += double(v) * double(v);
    return squares / double(values.size()) - sum / double(values.size()) * sum / double(values.size());
  };
  EXPECT_LT(variance(filtered), 0.5 * variance(copied));
  for (const float value : filtered) ASSERT_TRUE(value >= 0 && value <= 1);
  EXPECT_EQ(channel_of(ExrReader(path("copied.exr")), 0, "R"),
            channel_of(ExrReader(path("filtered.exr")), 0, "R"));
}

TEST_F(AlsoParts, WrongUsesAreOneClearError) {
  expect_failure(denoise("none.exr", also({"volume"})), 1,
                 {"sample_0.exr", "no part of the light is called 'volume'", "there are diffuse, glossy"});
  expect_failure(denoise("none.png", {"--also", "diffuse"}), 2,
                 {"none.png", "--also and --alpha filter go with EXR"});
  expect_failure(denoise("none.png", {"--alpha", "filter"}), 2, {"--also and --alpha filter go with EXR"});
  EXPECT_FALSE(std::filesystem::exists(path("none.exr")));
  Frame frame(4, 3, 2);
  frame.features = {"radiance"};
  std::fill(frame.samples.begin(), frame.samples.end(), 0.5F);
  write_frame(path("without.exr"), frame);
  expect_failure(denoise("none.exr", {"--alpha", "filter"}, {path("without.exr")}), 1,
                 {"without.exr", "no alpha to filter"});
}

TEST_F(AlsoParts, ThatAreNotFiniteAreReported) {
  Frame frame(4, 3, 2);
  frame.features = {"radiance"};
  std::fill(frame.samples.begin(), frame.samples.end(), 0.5F);
  frame.add_part("lamp").samples[5] = std::numeric_limits<float>::quiet_NaN();
  write_frame(path("holes.exr"), frame);
  const ProgramResult done =
      denoise("holes_out.exr", {"--also", "lamp", "--json", path("holes.json")}, {path("holes.exr")});
  EXPECT_EQ(done.exit_code, 0) << done.output;
  EXPECT_NE(done.output.find("1 colours of light parts are NaN or infinite"), std::string::npos)
      << done.output;
  const auto report = nlohmann::json::parse(read_file(path("holes.json")));
  EXPECT_EQ(report[0]["mended_parts"], 1);
  EXPECT_EQ(report[0]["also"], nlohmann::json({"lamp"}));
}

}  // namespace
}  // namespace ld
