// A wrong command line gets exit code 2 and one short line that says where the options are explained, from
// every program.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>

#include "tests/support/run_program.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

const std::vector<std::string> kPrograms = {"ld_bench",   "ld_denoise", "ld_eval",  "ld_export", "ld_import",
                                            "ld_inspect", "ld_render",  "ld_train", "ld_tune"};

size_t longest_number(const std::string& text) {
  size_t longest = 0, length = 0;
  for (const char c : text) {
    length = std::isdigit(static_cast<unsigned char>(c)) != 0 ? length + 1 : 0;
    longest = std::max(longest, length);
  }
  return longest;
}

/// Exit code 2 and nothing but one line, which begins with the program's name.
void expect_one_line(const std::string& program, const std::vector<std::string>& arguments,
                     const std::vector<std::string>& parts) {
  std::string command = program;
  for (const std::string& argument : arguments) command += " " + argument;
  SCOPED_TRACE(command);
  const ProgramResult result = run_program(program, arguments);
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_EQ(std::count(result.output.begin(), result.output.end(), '\n'), 1) << result.output;
  EXPECT_EQ(result.output.rfind(program + ": ", 0), 0u) << result.output;
  EXPECT_LT(result.output.size(), 300u) << result.output;
  EXPECT_LT(longest_number(result.output), 24u) << result.output;
  for (const std::string& part : parts)
    EXPECT_NE(result.output.find(part), std::string::npos)
        << "expected '" << part << "' in: " << result.output;
}

void expect_help(const std::string& program, const std::vector<std::string>& arguments,
                 const std::string& part = "") {
  expect_one_line(program, arguments, {part, "see " + program + " --help"});
}

TEST(CommandLines, WithoutArguments) {
  for (const std::string& program : kPrograms) expect_help(program, {});
}

TEST(CommandLines, UnknownArguments) {
  for (const std::string& program : kPrograms) expect_help(program, {"--no-such-option"});
  expect_help("ld_train", {"--config", "c.yaml", "--out", "run", "--no-such-option", "3"},
              "--no-such-option");
}

TEST(CommandLines, HalfTheArguments) {
  expect_help("ld_bench", {"tradeoff"}, "--data");
  expect_help("ld_bench", {"no_such_bench"});
  expect_help("ld_denoise", {"frame.exr"}, "--output");
  expect_help("ld_eval", {"--data", "set"}, "--out");
  expect_help("ld_export", {"--format", "onnx", "--out", "m.onnx"}, "--model or --untrained");
  expect_help("ld_export", {"--model", "m", "--format", "pickle", "--out", "o"}, "pickle");
  expect_help("ld_import", {"--preset", "cycles", "s.exr"}, "--out");
  expect_help("ld_import", {"--preset", "cycles", "--out", "set", "s.exr"}, "--name and --reference");
  expect_help("ld_import", {"--from-hdf5", "s.h5", "--out", "set"}, "--reference");
  expect_help("ld_import", {"--print-mapping"}, "--preset");
  expect_help("ld_render", {"--out", "set"}, "--recipe FILE or --scene FILE");
  expect_help("ld_render", {"--recipe", std::string(LD_SOURCE_DIR) + "/data/recipes/quick.yaml"},
              "--out DIR");
  expect_help("ld_render", {"--recipe", "r.yaml", "--views", "3", "--out", "set"}, "--scene");
  expect_help("ld_train", {"--config", "c.yaml"}, "--out");
  expect_help("ld_train", {"--out", "run"}, "--config");
}

TEST(CommandLines, NumbersBeyondTheirRange) {
  for (const std::string& program : kPrograms) expect_help(program, {"--threads", "0"}, "--threads");
  expect_help("ld_inspect", {"--threads", "many"}, "--threads");
  expect_help("ld_inspect", {"--threads", "1.5"}, "expected a whole number from 1 to 4096, found '1.5'");
  expect_help("ld_inspect", {"--seed", "one"}, "--seed");
  struct Option {
    const char *program, *option;
  };
  for (const Option& option : std::initializer_list<Option>{{"ld_denoise", "--samples"},
                                                            {"ld_denoise", "--max-memory"},
                                                            {"ld_eval", "--frames-limit"},
                                                            {"ld_eval", "--samples"},
                                                            {"ld_eval", "--report-frames"},
                                                            {"ld_eval", "--report-side"},
                                                            {"ld_export", "--allowed"},
                                                            {"ld_inspect", "--frames"},
                                                            {"ld_render", "--columns"},
                                                            {"ld_render", "--preview-spp"},
                                                            {"ld_render", "--views"}})
    expect_help(option.program, {option.option, "-1"}, option.option);
  for (const char* value : {"1e300", "few"}) expect_help("ld_inspect", {"--frames", value}, "--frames");
  expect_help("ld_inspect", {"path", "--frames", "0"}, "1000000");
}

TEST(CommandLines, ASplitThatIsNotThere) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 2);
  const std::string data = (folder / "data").string(), out = (folder / "out").string();
  expect_one_line("ld_eval", {"--data", data, "--split", "testt", "--out", out}, {"testt", "validation"});
  expect_one_line("ld_bench",
                  {"tradeoff", "--data", data, "--split", "testt", "--model", "common_fast=common_fast"},
                  {"testt", "validation"});
  expect_help("ld_import", {"--to-hdf5", "s.h5", "--reference", "r.h5", "--out", data, "--split", "testt"},
              "testt");
  expect_help("ld_import",
              {"--preset", "cycles", "--out", out, "--name", "a", "--split", "testt", "--reference", "r.exr",
               "s.exr"},
              "testt");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(CommandLines, ATrainingWithoutValidationNamesNoBestLoss) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 4);
  Manifest manifest = read_manifest(folder / "data");
  manifest.frames.resize(4);  // those of the training split
  std::filesystem::remove(folder / "data/manifest.json");
  add_to_manifest(folder / "data", manifest);
  write_file_atomically(
      folder / "train.yaml",
      tiny_network_yaml() + "data: {crop: 8, batch: 2}\nrun: {max_steps: 2, validate_every: 1}\n");
  const ProgramResult result = run_program(
      "ld_train", {"--config", (folder / "train.yaml").string(), "data.path=" + (folder / "data").string(),
                   "--out", (folder / "run").string()});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("2 of 2000 steps done; no validation"), std::string::npos) << result.output;
  EXPECT_EQ(result.output.find("inf;"), std::string::npos) << result.output;
  EXPECT_EQ(result.output.find("loss inf"), std::string::npos) << result.output;
}

}  // namespace
}  // namespace ld
