// One clear line and the right exit code for each kind of bad input, seen from the command line.
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "tests/support/run_program.h"
#include "tests/support/tiny_dataset.h"
#include "weights/safetensors.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// A data set, a config and a trained model, made once for all tests here; each test copies what it damages.
class BadInput : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TemporaryFolder;
    write_tiny_dataset(*shared_ / "data", 4);
    write_file_atomically(*shared_ / "train.yaml",
                          tiny_network_yaml() + "data:\n  crop: 8\n  batch: 2\nrun:\n  max_steps: 2\n");
    const ProgramResult trained = train(config(), "run");
    ASSERT_EQ(trained.exit_code, 0) << trained.output;
    ASSERT_EQ(run_program("ld_export", {"--model", path("run"), "--format", "safetensors", "--out",
                                        path("model.safetensors")})
                  .exit_code,
              0);
  }
  static void TearDownTestSuite() { delete shared_; }

  static std::string path(const std::string& name) { return (*shared_ / name).string(); }
  static std::string config() { return path("train.yaml"); }
  static std::string frame() { return path("data/frame_5.exr"); }

  static ProgramResult train(const std::string& config_path, const std::string& run,
                             std::vector<std::string> overrides = {}, const std::string& data = "data") {
    std::vector<std::string> arguments = {"--config", config_path, "--out", path(run),
                                          "data.path=" + path(data)};
    arguments.insert(arguments.end(), overrides.begin(), overrides.end());
    return run_program("ld_train", arguments);
  }
  static ProgramResult denoise(const std::string& model, const std::string& input) {
    fs::remove(path("out.exr"));
    ProgramResult result = run_program("ld_denoise", {"--model", model, input, "--output", path("out.exr")});
    EXPECT_EQ(fs::exists(path("out.exr")), result.exit_code == 0)
        << "an output exists exactly when it succeeded";
    return result;
  }
  static std::string config_file(const std::string& text) {
    write_file_atomically(path("bad.yaml"), text);
    return path("bad.yaml");
  }

  static TemporaryFolder* shared_;
};
TemporaryFolder* BadInput::shared_ = nullptr;

TEST_F(BadInput, GoodInputWorks) {
  const ProgramResult result = denoise(path("model.safetensors"), frame());
  EXPECT_EQ(result.exit_code, 0) << result.output;
  const Image image = read_image(path("out.exr"));
  EXPECT_EQ(image.width, 16);
  EXPECT_EQ(denoise(path("run"), frame()).exit_code, 0);
}

TEST_F(BadInput, CommandLines) {
  expect_failure(run_program("ld_denoise", {"--modell", "x"}), 2, {"ld_denoise", "--help"});
  expect_failure(run_program("ld_train", {"--config"}), 2, {"ld_train"});
  expect_failure(run_program("ld_export", {"--model", "m", "--format", "pickle", "--out", "o"}), 2,
                 {"pickle"});
  EXPECT_EQ(run_program("ld_train", {"--help"}).exit_code, 0);
  EXPECT_NE(run_program("ld_train", {"--help"}).output.find("--config"), std::string::npos);
  EXPECT_NE(run_program("ld_denoise", {"--version"}).output.find("ld_denoise 0."), std::string::npos);
}

TEST_F(BadInput, WhatContradictsItselfOrFitsNothingIsAWrongCommandLine) {
  expect_failure(train(config(), "two_seeds", {"--seed", "5", "seed=6"}), 2, {"--seed 5", "seed=6"});
  expect_failure(
      train(config(), "misfit", {"init=" + path("model.safetensors"), "network.sample_reducer=[7, 7]"}), 2,
      {"init: ", "sizes"});
  expect_failure(run_program("ld_import", {"--preset", "cycles", "--out", path("imported"), "--name", "a",
                                           "--reference", "r.exr", "s.exr"}),
                 2, {"--split", "validation"});
}

TEST_F(BadInput, AnOnnxModelSaysWhatItTakes) {
  const ProgramResult exported = run_program(
      "ld_export", {"--model", path("model.safetensors"), "--format", "onnx", "--out", path("model.onnx")});
  ASSERT_EQ(exported.exit_code, 0) << exported.output;
  const ProgramResult told = run_program("ld_inspect", {path("model.onnx")});
  EXPECT_EQ(told.exit_code, 0) << told.output;
  EXPECT_NE(told.output.find("radiance [B, S, 3, H, W]"), std::string::npos) << told.output;
  write_file_atomically(path("cut.onnx"), read_file(path("model.onnx")).substr(0, 500));
  EXPECT_EQ(run_program("ld_inspect", {path("cut.onnx")}).exit_code, 1);
}

TEST_F(BadInput, EqualWeightsMakeEqualFilesWhereverTheyLie) {
  fs::copy_file(path("model.safetensors"), path("other_name.safetensors"));
  ASSERT_EQ(denoise(path("model.safetensors"), frame()).exit_code, 0);
  const std::string first = read_file(path("out.exr"));
  ASSERT_EQ(denoise(path("other_name.safetensors"), frame()).exit_code, 0);
  EXPECT_TRUE(read_file(path("out.exr")) == first);
}

TEST_F(BadInput, MissingFiles) {
  expect_failure(denoise(path("model.safetensors"), path("none.exr")), 1, {"none.exr"});
  expect_failure(denoise(path("none.safetensors"), frame()), 1, {"none.safetensors"});
  expect_failure(train(path("none.yaml"), "run_none"), 1, {"none.yaml"});
  expect_failure(train(config(), "run_none", {}, "none"), 1, {"none"});
  expect_failure(run_program("ld_inspect", {path("none")}), 1, {"none"});
  EXPECT_FALSE(fs::exists(path("run_none/config.yaml")));
}

TEST_F(BadInput, TruncatedExr) {
  const std::string bytes = read_file(frame());
  for (const size_t length : {size_t{0}, size_t{3}, size_t{400}, bytes.size() / 2, bytes.size() - 1}) {
    write_file_atomically(path("cut.exr"), bytes.substr(0, length));
    expect_failure(denoise(path("model.safetensors"), path("cut.exr")), 1, {"cut.exr"});
  }
}

TEST_F(BadInput, ExrWithoutANeededChannel) {
  write_image(path("picture.exr"), Image(16, 16, 3));
  expect_failure(denoise(path("model.safetensors"), path("picture.exr")), 1,
                 {"picture.exr", "not the feature 'normal'"});
  // Renaming a channel within the header keeps every length: 'lens.X' is gone.
  std::string bytes = read_file(frame());
  for (size_t at = bytes.find("lens.X"); at != std::string::npos; at = bytes.find("lens.X"))
    bytes.replace(at, 6, "lens.V");
  write_file_atomically(path("renamed.exr"), bytes);
  expect_failure(denoise(path("model.safetensors"), path("renamed.exr")), 1, {"renamed.exr", "lens.X"});
}

TEST_F(BadInput, InputAndReferenceOfDifferentSize) {
  fs::copy(path("data"), path("data_size"));
  write_image(path("data_size/frame_1.reference.exr"), Image(8, 16, 3));
  expect_failure(train(config(), "run_size", {}, "data_size"), 1,
                 {"16 x 16", "8 x 16", "frame_1.reference.exr"});
  write_image(path("data_size/frame_5.reference.exr"), Image(8, 16, 3));
  expect_failure(run_program("ld_eval", {"--data", path("data_size"), "--out", path("eval")}), 1,
                 {"16 x 16", "8 x 16", "frame_5.reference.exr"});
}

TEST_F(BadInput, NanAndInfinitePixelsAreMaskedCountedAndReported) {
  Frame broken = random_frame(16, 16, 2, 5);
  broken.plane(0, 0)[3] = std::numeric_limits<float>::quiet_NaN();
  broken.plane(1, 1)[4] = std::numeric_limits<float>::infinity();
  broken.plane(1, 2)[5] = -1;
  write_frame(path("broken.exr"), broken);
  const ProgramResult result = denoise(path("model.safetensors"), path("broken.exr"));
  EXPECT_EQ(result.exit_code, 0);
  EXPECT_NE(result.output.find("2 samples with NaN or infinity masked out, 1 negative"), std::string::npos)
      << result.output;
  for (const float value : read_image(path("out.exr")).pixels) ASSERT_TRUE(std::isfinite(value));
}

TEST_F(BadInput, ConfigKeys) {
  expect_failure(train(config_file("seed: 1\noptimiser:\n  rate: 1\n"), "run_bad"), 2,
                 {"bad.yaml:2", "'optimiser'", "did you mean 'optimizer'"});
  expect_failure(train(config_file("seed: 1\nseed: 2\n"), "run_bad"), 2,
                 {"bad.yaml:2", "duplicate key 'seed'"});
  expect_failure(train(config_file("\nepochs: many\n"), "run_bad"), 2, {"bad.yaml:2", "epochs", "'many'"});
  expect_failure(train(config_file("network:\n  features: [radiance, albido]\n"), "run_bad"), 2,
                 {"albido", "'albedo'"});
  expect_failure(train(config(), "run_bad", {"data.corp=4"}), 2, {"command line", "data.corp", "data.crop"});
  expect_failure(train(config(), "run_bad", {"network.kernel_size=4"}), 2, {"kernel_size"});
  expect_failure(train(config(), "run_bad", {"loss=l7"}), 2, {"l7"});
  EXPECT_FALSE(fs::exists(path("run_bad")));
}

TEST_F(BadInput, AGpuThatIsNotThere) {
  const auto train_without_gpu = [](const std::string& config_path, const std::string& override_text) {
    RunningProgram program("ld_train",
                           {"--config", config_path, "--out", path("gpu"), "data.path=none", override_text},
                           {{"CUDA_VISIBLE_DEVICES", ""}});
    const int code = program.wait();
    return ProgramResult{code, program.output()};
  };
  expect_failure(train_without_gpu(config(), "run.device=cuda"), 2,
                 {"command line: run.device: expected cpu, or cuda", "found cuda and ", "run.device=cpu"});
  const std::string file = config_file(read_file(config()) + "  device: cuda\n");
  expect_failure(train_without_gpu(file, "seed=2"), 2, {"bad.yaml:", "run.device: expected cpu, or cuda"});
  expect_failure(train_without_gpu(config(), "run.device=gpu"), 2, {"run.device", "one of cpu, cuda"});
  EXPECT_FALSE(fs::exists(path("gpu")));
}

TEST_F(BadInput, DamagedWeights) {
  const std::string bytes = read_file(path("model.safetensors"));
  for (const size_t length : {size_t{0}, size_t{5}, size_t{100}, bytes.size() / 2, bytes.size() - 1}) {
    write_file_atomically(path("cut.safetensors"), bytes.substr(0, length));
    expect_failure(denoise(path("cut.safetensors"), frame()), 1, {"cut.safetensors"});
  }
  std::string lying = bytes;
  lying[6] = '\x7f';  // a header of 10^16 bytes
  write_file_atomically(path("lying.safetensors"), lying);
  expect_failure(denoise(path("lying.safetensors"), frame()), 1, {"lying.safetensors"});
}

TEST_F(BadInput, WeightsForAnotherFeatureSet) {
  const SafetensorsFile file(path("model.safetensors"));
  Metadata metadata = file.metadata();
  std::string& features = metadata.at("features");
  features.replace(features.find("squash 16"), 9, "squash 99");
  write_safetensors(path("other.safetensors"), file.tensors(), metadata);
  expect_failure(denoise(path("other.safetensors"), frame()), 1, {"other.safetensors", "motion"});
}

TEST_F(BadInput, DataSetsTooSmall) {
  fs::create_directories(path("empty"));
  expect_failure(train(config(), "run_empty", {}, "empty"), 1, {"manifest.json"});
  write_file_atomically(path("empty/manifest.json"),
                        R"({"format": "ld-dataset", "version": 1, "frames": []})");
  expect_failure(train(config(), "run_empty", {}, "empty"), 1, {"train", "empty"});
  expect_failure(run_program("ld_eval", {"--data", path("empty"), "--out", path("eval")}), 1,
                 {"test", "empty"});
  expect_failure(train(config(), "run_empty", {"data.batch=5"}), 2, {"data.batch", "5", "4"});
  EXPECT_FALSE(fs::exists(path("run_empty/config.yaml")));
}

TEST_F(BadInput, ARunFolderWithAnotherConfig) {
  expect_failure(train(config(), "run", {"optimizer.learning_rate=0.5"}), 2, {"run", "learning_rate: 0.5"});
  EXPECT_EQ(train(config(), "run").exit_code, 0);
}

}  // namespace
}  // namespace ld
