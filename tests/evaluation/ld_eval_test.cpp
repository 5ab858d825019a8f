// ld_eval as a user meets it: what it prints, what it leaves behind, how it fails.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "evaluation/data_set.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "metrics/metric.h"
#include "test_frames.h"
#include "tests/support/run_program.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

class LdEval : public testing::Test {
 protected:
  void SetUp() override { write_tiny_dataset(folder_ / "data", 3); }

  std::string path(const std::string& name) const { return (folder_ / name).string(); }
  ProgramResult run(std::vector<std::string> more = {}) const {
    std::vector<std::string> arguments = {"--data", path("data"), "--out", path("out")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program("ld_eval", arguments);
  }

  TemporaryFolder folder_;
};

TEST_F(LdEval, WithoutModelsItComparesTheBaselinesAndWritesAllFiles) {
  const ProgramResult result = run({"--split", "train", "--json", path("copy.json")});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* text : {"| method ", "| noisy ", "| blur ", "epsilon 0.0001",
                           "its width chosen for each metric", "(d - r)^2 / (r^2 + 0.0001)",
                           "95 % confidence intervals", "In pairs with noisy", "3 frames are too few"})
    EXPECT_NE(result.output.find(text), std::string::npos) << text << " in\n" << result.output;
  EXPECT_EQ(result.output.find("| frame_"), std::string::npos) << "rows for each frame only on request";
  for (const char* name : {"metrics.csv", "metrics.json", "comparison.csv", "comparison.png", "report.html",
                           "strips/frame_0.png", "strips/frame_1.png", "strips/frame_2.png"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / name)) << name;

  // The numbers are those of the library, up to JSON's text.
  const auto expected = evaluate(open_frame_set(folder_ / "data", "train", {"radiance"}, 0), {}, {});
  const auto json = nlohmann::json::parse(read_file(folder_ / "out" / "metrics.json"));
  EXPECT_EQ(json, nlohmann::json::parse(read_file(folder_ / "copy.json")));
  EXPECT_EQ(json["frame_count"], 3);
  for (size_t m = 0; m < metrics().size(); ++m) {
    const std::string& name = metrics()[m].name;
    EXPECT_DOUBLE_EQ(json["methods"]["blur"]["mean"][name], expected->method("blur").mean(m));
    // The tiny references are the means of the samples themselves: noisy differs by half's rounding alone.
    EXPECT_TRUE(better(metrics()[m], expected->method("noisy").mean(m), expected->method("blur").mean(m)))
        << name;
  }
}

TEST_F(LdEval, AModelIsScoredOnWhatTheInferenceProgramMakesOfTheFrame) {
  write_file_atomically(folder_ / "tiny.yaml",
                        tiny_network_yaml() + "data:\n  crop: 8\n  batch: 2\nrun:\n  max_steps: 2\n");
  const ProgramResult trained = run_program(
      "ld_train", {"--config", path("tiny.yaml"), "--out", path("run"), "data.path=" + path("data")});
  ASSERT_EQ(trained.exit_code, 0) << trained.output;
  const ProgramResult result = run({"--model", "tiny=" + path("run")});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("| tiny "), std::string::npos) << result.output;

  const ProgramResult denoised = run_program(
      "ld_denoise", {"--model", path("run"), path("data/frame_4.exr"), "--output", path("denoised.exr")});
  ASSERT_EQ(denoised.exit_code, 0) << denoised.output;
  const Image image = read_image(folder_ / "denoised.exr");
  const Image reference = read_image(folder_ / "data" / "frame_4.reference.exr");
  const auto json = nlohmann::json::parse(read_file(folder_ / "out" / "metrics.json"))["methods"]["tiny"];
  for (const Metric& metric : metrics())  // the EXR holds half floats
    EXPECT_NEAR(json["mean"][metric.name].get<double>() / metric.compute(image, reference), 1, 1e-3)
        << metric.name;
  EXPECT_GT(json["seconds"].get<double>(), 0);
  EXPECT_EQ(json["not_finite"], 0);
  EXPECT_GT(json["parameters"].get<int>(), 100);
  EXPECT_GT(json["multiply_adds_per_pixel"].get<double>(), 100);
}

TEST_F(LdEval, PicturesOfAnotherDenoiserAreScoredAndCompared) {
  fs::create_directory(folder_ / "other");
  for (int i = 0; i < 3; ++i) {
    const std::string name = "frame_" + std::to_string(i);
    fs::copy_file(folder_ / "data" / (name + ".reference.exr"), folder_ / "other" / (name + ".exr"));
  }
  const ProgramResult result =
      run({"--images", "oidn=" + path("other"), "--baseline", "blur", "--split", "train"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const auto json = nlohmann::json::parse(read_file(folder_ / "out" / "metrics.json"));
  EXPECT_EQ(json["methods"]["oidn"]["mean"]["smape"], 0);
  EXPECT_FALSE(json["methods"]["oidn"].contains("seconds"));
  EXPECT_EQ(json["comparison"]["baseline"], "blur");
  EXPECT_EQ(json["comparison"]["methods"]["oidn"]["smape"]["better"], 3);
  EXPECT_NE(read_file(folder_ / "out" / "comparison.csv").find("blur,oidn,smape,3,-"), std::string::npos);

  fs::remove(folder_ / "other" / "frame_1.exr");
  expect_failure(run({"--images", "oidn=" + path("other"), "--split", "train"}), 1,
                 {"frame_1.exr is missing (1 of 3 frames"});
  expect_failure(run({"--images", "oidn"}), 2, {"expected NAME=DIR"});
  expect_failure(run({"--baseline", "oidn"}), 2, {"--baseline oidn", "noisy, blur"});
}

TEST_F(LdEval, FormulasNeedNoDataSet) {
  const ProgramResult result = run_program("ld_eval", {"--formulas"});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  for (const Metric& metric : metrics())
    EXPECT_NE(result.output.find(metric.title + " = " + metric.formula), std::string::npos) << result.output;
}

TEST_F(LdEval, TheFirstSamplesAloneOnRequest) {
  const ProgramResult result = run({"--split", "train", "--samples", "1"});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const auto json = nlohmann::json::parse(read_file(folder_ / "out" / "metrics.json"));
  EXPECT_EQ(json["samples"], 1);
  const auto expected = evaluate(open_frame_set(folder_ / "data", "train", {"radiance"}, 0, 1), {}, {}),
             two = evaluate(open_frame_set(folder_ / "data", "train", {"radiance"}, 0), {}, {});
  for (const char* name : {"noisy", "blur"})
    for (size_t m = 0; m < metrics().size(); ++m) {
      EXPECT_DOUBLE_EQ(json["methods"][name]["mean"][metrics()[m].name], expected->method(name).mean(m));
      EXPECT_TRUE(better(metrics()[m], two->method(name).mean(m), expected->method(name).mean(m))) << name;
    }
  expect_failure(run({"--split", "train", "--samples", "3"}), 1,
                 {"frame_0.exr: 2 samples a pixel, but 3 are asked for"});
  expect_failure(run({"--samples", "0"}), 2, {"--samples"});
}

TEST_F(LdEval, RowsForEachFrameAndALimitOnRequest) {
  const ProgramResult two = run({"--split", "train", "--per-frame", "--frames-limit", "2"});
  EXPECT_NE(two.output.find("| frame_1 | blur "), std::string::npos) << two.output;
  EXPECT_EQ(two.output.find("frame_2"), std::string::npos) << two.output;
}

/// Two sequences of three frames of a still wall, in the test split.
void write_sequences(const fs::path& folder) {
  Manifest manifest;
  for (int i = 0; i < 6; ++i) {
    const EvaluationFrame frame = still_frame("s" + std::to_string(i), 20, 18, i / 3, i % 3);
    write_frame(frame_path(folder, frame.name), frame.frame);
    write_image(reference_path(folder, frame.name), frame.reference);
    ManifestFrame entry;
    entry.name = frame.name;
    entry.split = "test";
    entry.sequence = i / 3;
    entry.position = i % 3;
    manifest.frames.push_back(entry);
  }
  add_to_manifest(folder, manifest);
}

TEST_F(LdEval, SequencesAreMeasuredAndPlayedAndBecomeFilms) {
  fs::create_directories(folder_ / "moving");
  write_sequences(folder_ / "moving");
  const std::vector<std::string> command = {"--data",      path("moving"), "--out",       path("out"),
                                            "--sequences", "--metrics",    "flip",        "--movies",
                                            "mp4",         "--json",       path("a.json")};
  const ProgramResult result = run_program("ld_eval", command);
  ASSERT_EQ(result.exit_code, 0) << result.output;
  for (const char* text : {"Over whole sequences:", "steadier", "means over 2 sequences", "| FLIP"})
    EXPECT_NE(result.output.find(text), std::string::npos) << text << " in\n" << result.output;
  for (const char* name : {"sequences.csv", "sequence_comparison.csv", "sequence_error.svg"})
    EXPECT_TRUE(fs::exists(folder_ / "out" / name)) << name;
  for (const char* film : {"s0", "s3"})
    EXPECT_TRUE(fs::exists(folder_ / "out/movies" / (std::string(film) + ".mp4")) ||
                fs::exists(folder_ / "out/movies" / film / "000002.png"));
  const auto json = nlohmann::json::parse(read_file(folder_ / "a.json"));
  EXPECT_EQ(json["sequences"]["frame_count"], 2);
  EXPECT_GT(json["sequences"]["methods"]["blur"]["mean"]["steadier"], 1);
  EXPECT_GT(json["methods"]["noisy"]["mean"]["flip"], 0);
  EXPECT_NE(read_file(folder_ / "out/report.html").find("id=\"clip-1-2-0\""), std::string::npos);
}

TEST_F(LdEval, WhereNoFramesFollowOneAnotherSequencesAreAnError) {
  expect_failure(run({"--sequences"}), 1, {"no two frames of this split follow one another"});
  expect_failure(run({"--movies", "webm"}), 2, {"--movies webm", "follow one another"});
  expect_failure(run({"--movies", "avi"}), 2, {"--movies"});
  expect_failure(run({"--metrics", "flop"}), 2, {"no metric 'flop', did you mean 'flip'?"});
}

TEST_F(LdEval, TheSameFramesGiveTheSameBytes) {
  ASSERT_EQ(run().exit_code, 0);
  const std::string json = read_file(folder_ / "out" / "metrics.json"),
                    strip = read_file(folder_ / "out/strips/frame_4.png"),
                    report = read_file(folder_ / "out/report.html");
  fs::remove_all(folder_ / "out");
  ASSERT_EQ(run({"--threads", "3"}).exit_code, 0);
  EXPECT_EQ(read_file(folder_ / "out" / "metrics.json"), json);
  EXPECT_EQ(read_file(folder_ / "out/strips/frame_4.png"), strip);
  EXPECT_EQ(read_file(folder_ / "out/report.html"), report);
}

TEST_F(LdEval, TheResultReplacesNoFileOfTheDataSet) {
  const std::string manifest = read_file(path("data/manifest.json"));
  expect_failure(run({"--split", "train", "--json", path("data/manifest.json")}), 2,
                 {"is a file of the input"});
  EXPECT_EQ(read_file(path("data/manifest.json")), manifest);
}

TEST_F(LdEval, WrongCommandLinesExitWithTwoAndWriteNothing) {
  expect_failure(run_program("ld_eval", {"--data", path("data")}), 2, {"--out", "--help"});
  expect_failure(run({"--model", "blur=x"}), 2, {"'blur'", "choose another"});
  expect_failure(run({"--frames-limit", "-3"}), 2, {"--frames-limit"});
  EXPECT_FALSE(fs::exists(folder_ / "out"));
}

TEST_F(LdEval, MissingThingsExitWithOneAndAreNamed) {
  expect_failure(run({"--model", "layer=" + path("nowhere.safetensors")}), 1, {"nowhere.safetensors"});
  expect_failure(run({"--split", "holiday"}), 2, {"holiday", "data", "train"});
  fs::remove(folder_ / "data" / "frame_4.reference.exr");
  expect_failure(run(), 1, {"frame_4.reference.exr"});
  EXPECT_FALSE(fs::exists(folder_ / "out" / "metrics.json"));
}

}  // namespace
}  // namespace ld
