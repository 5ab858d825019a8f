// Options take one value each and may stand before and behind the files, in every program; what goes together
// badly is a wrong command line before any work.
#include <gtest/gtest.h>

#include <algorithm>

#include "tests/support/run_program.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// What stays together on a command line: an option with its value, a flag, a file.
using Words = std::vector<std::string>;

class OptionOrder : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    shared_ = new TemporaryFolder;
    write_tiny_dataset(*shared_ / "data", 4);
    write_file_atomically(*shared_ / "train.yaml", tiny_network_yaml() + "data:\n  crop: 8\n  batch: 2\n");
    const ProgramResult exported = run_program(
        "ld_export",
        {"--untrained", path("train.yaml"), "--format", "safetensors", "--out", path("model.safetensors")});
    ASSERT_EQ(exported.exit_code, 0) << exported.output;
  }
  static void TearDownTestSuite() { delete shared_; }
  static std::string path(const std::string& name) { return (*shared_ / name).string(); }
  static std::string frame() { return path("data/frame_5.exr"); }

  /// Runs the program with the groups as they are, backwards, and with the second half first. Each time it
  /// must end with the code and say the text.
  static void expect_the_same(const std::string& program, const std::vector<Words>& groups, int exit_code,
                              const std::string& text, const Words& subcommand = {}) {
    std::vector<std::vector<Words>> orders(3, groups);
    std::reverse(orders[1].begin(), orders[1].end());
    std::rotate(orders[2].begin(), orders[2].begin() + std::ptrdiff_t(groups.size() / 2), orders[2].end());
    for (const std::vector<Words>& order : orders) {
      Words arguments = subcommand;
      for (const Words& group : order) arguments.insert(arguments.end(), group.begin(), group.end());
      const ProgramResult result = run_program(program, arguments);
      std::string line = program;
      for (const std::string& argument : arguments) line += " " + argument;
      EXPECT_EQ(result.exit_code, exit_code) << line << "\n" << result.output;
      EXPECT_NE(result.output.find(text), std::string::npos) << line << "\n" << result.output;
    }
  }

  static TemporaryFolder* shared_;
};
TemporaryFolder* OptionOrder::shared_ = nullptr;

TEST_F(OptionOrder, Denoise) {
  expect_the_same("ld_denoise",
                  {{frame()},
                   {"--kernel-at", "1,1"},
                   {"--aovs", "layers"},
                   {"--model", path("model.safetensors")},
                   {"--kernel-at", "2,2"},
                   {"--output", path("out.exr")},
                   {"--float"}},
                  0, "denoised in");
  expect_the_same("ld_denoise",
                  {{path("no_1.exr")},
                   {"--set", "layer=A"},
                   {path("no_2.exr")},
                   {"--set", "part=B"},
                   {"--preset", "cycles"},
                   {"--output", path("out.exr")}},
                  1, "no_");
}

TEST_F(OptionOrder, Import) {
  const std::string fixtures = std::string(LD_SOURCE_DIR) + "/tests/fixtures/import/cycles/";
  expect_the_same("ld_import",
                  {{fixtures + "sample_00.exr"},
                   {"--set", "flow.channels=[]"},
                   {fixtures + "sample_01.exr"},
                   {"--set", "normal.channels=[]"},
                   {"--preset", "cycles"},
                   {"--frame", path("imported.exr")}},
                  0, "2 samples");
}

TEST_F(OptionOrder, Train) {
  expect_the_same("ld_train",
                  {{"data.path=" + path("nowhere")},
                   {"--config", path("train.yaml")},
                   {"data.crop=8"},
                   {"--out", path("run")},
                   {"--threads", "1"}},
                  1, "nowhere");
}

TEST_F(OptionOrder, Render) {
  expect_the_same("ld_render",
                  {{"spp=-3"},
                   {"--recipe", std::string(LD_SOURCE_DIR) + "/data/recipes/quick.yaml"},
                   {"resolution=[8, 8]"},
                   {"--out", path("rendered")},
                   {"--frames", "0:1"}},
                  2, "spp");
}

TEST_F(OptionOrder, Eval) {
  expect_the_same("ld_eval",
                  {{"--model", "a=" + path("model.safetensors")},
                   {"--images", "b=" + path("data")},
                   {"--model", "c=" + path("model.safetensors")},
                   {"--data", path("nowhere")},
                   {"--out", path("eval")}},
                  1, "nowhere");
  expect_failure(run_program("ld_eval", {"--data", path("data"), "--out", path("eval"), "--model",
                                         "a=" + path("model.safetensors"), "b=" + path("model.safetensors")}),
                 2, {"b=", "not expected"});
}

TEST_F(OptionOrder, Export) {
  expect_the_same("ld_export",
                  {{"--check-frame", frame()},
                   {"--model", path("model.safetensors")},
                   {"--check-frame", path("data/frame_4.exr")},
                   {"--format", "safetensors"},
                   {"--out", path("exported.safetensors")},
                   {"--dtype", "f32"}},
                  0, "exported.safetensors");
}

TEST_F(OptionOrder, Inspect) {
  expect_the_same(
      "ld_inspect",
      {{path("model.safetensors")}, {"--frames", "1"}, {"--verify"}, {"--json", path("report.json")}}, 0,
      "weights");
}

TEST_F(OptionOrder, Bench) {
  expect_the_same(
      "ld_bench",
      {{path("none.yaml")}, {"--repeats", "1"}, {path("no.yaml")}, {"--quick"}, {"--threads", "1"}}, 1,
      ".yaml", {"config"});
  expect_the_same("ld_bench",
                  {{"--model", "a=" + path("model.safetensors")},
                   {"--images", "b=" + path("data")},
                   {"--data", path("nowhere")},
                   {"--model", "c=" + path("model.safetensors")}},
                  1, "nowhere", {"tradeoff"});
  expect_failure(run_program("ld_bench", {"loader", "--data", path("data"), "--samples", "1", "2"}), 2,
                 {"not expected"});
}

TEST_F(OptionOrder, SeveralPicturesNeedAFolderAndFloatsAnExr) {
  expect_failure(run_program("ld_denoise", {"--model", path("model.safetensors"), frame(),
                                            path("data/frame_4.exr"), "--output", path("x.exr")}),
                 2, {"2 pictures for one output", "x.exr"});
  expect_failure(run_program("ld_denoise", {"--model", path("model.safetensors"), frame(), "--float",
                                            "--output", path("x.png")}),
                 2, {"--float goes with EXR"});
  EXPECT_FALSE(fs::exists(path("x.exr")));
  EXPECT_FALSE(fs::exists(path("x.png")));
}

}  // namespace
}  // namespace ld
