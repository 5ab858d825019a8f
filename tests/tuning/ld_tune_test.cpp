// ld_tune as a user starts it, on a data set that is made in a moment.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "core/json_text.h"
#include "tests/benchmark/xml_check.h"
#include "tests/support/run_program.h"
#include "tests/support/tiny_dataset.h"
#include "weights/network_weights.h"

namespace ld {
namespace {

class LdTune : public ::testing::Test {
 protected:
  LdTune() : data_(folder_ / "data"), out_(folder_ / "tuned.safetensors"), work_(out_.string() + ".tune") {
    write_tiny_dataset(data_, 2, 16, 2);
  }
  ProgramResult tune(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"--data",    data_.string(), "--out",       out_.string(),
                                          "--minutes", "0.1",          "--threads",   "1",
                                          "steps=2",   "data.crop=8",  "data.batch=1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program("ld_tune", arguments);
  }
  TemporaryFolder folder_;
  std::filesystem::path data_, out_, work_;
};

TEST_F(LdTune, FindsAModelThatTheRuntimeRuns) {
  const ProgramResult result = tune({"--budget-ms", "10000", "--json", (folder_ / "t.json").string()});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  EXPECT_GT(parameters(read_network_weights(out_).graph).size(), 0);
  EXPECT_NE(read_file(folder_ / "tuned.md").find("How it was found"), std::string::npos);
  EXPECT_EQ(xml_fault(read_file(work_ / "front.svg")), "");
  EXPECT_NE(read_file(work_ / "table.md").find("(chosen)"), std::string::npos);
  const auto json = parse_json(read_file(folder_ / "t.json"), "t.json");
  EXPECT_EQ(json, parse_json(read_file(work_ / "table.json"), "table.json"));
  bool chosen_is_unbeaten = false;
  for (const auto& point : json.at("points"))
    if (point.at("name") == json.at("chosen")) chosen_is_unbeaten = point.at("unbeaten");
  EXPECT_TRUE(chosen_is_unbeaten);
  EXPECT_NE(result.output.find("flow: dropped, no frame holds it."), std::string::npos) << result.output;
  EXPECT_TRUE(std::filesystem::exists(work_ / "trials/final/config.yaml"));

  // What is done is read, and only that: scores that are changed come back.
  const std::filesystem::path score = work_ / "trials/final.json";
  write_file_atomically(score, R"({"smape": [0.0009765625]})");
  const ProgramResult again = tune({"--budget-ms", "10000"});
  ASSERT_EQ(again.exit_code, 0) << again.output;
  EXPECT_EQ(again.output.find("] training "), std::string::npos) << again.output;
  EXPECT_NE(again.output.find("0.00098"), std::string::npos) << again.output;

  expect_failure(tune({"--budget-ms", "9000"}), 2, {"another search", "budget_ms was 10000", "is 9000"});
}

TEST_F(LdTune, AnInterruptReachesTheTraining) {
  const std::vector<std::string> arguments = {
      "--data", data_.string(), "--out",        out_.string(), "--minutes",   "0.1",   "--threads",
      "1",      "data.crop=8",  "data.batch=1", "steps=400",   "--budget-ms", "10000", "run.log_every=1"};
  const std::filesystem::path trial = work_ / "trials/layer2_fine_k9_rung0";
  RunningProgram program("ld_tune", arguments);
  for (int i = 0; i < 600 && !std::filesystem::exists(trial / "metrics.csv"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  program.signal(SIGINT);
  EXPECT_EQ(program.wait(), 130) << program.output();
  EXPECT_NE(program.output().find("the same command goes on"), std::string::npos) << program.output();
  EXPECT_FALSE(std::filesystem::exists(out_));
  EXPECT_FALSE(std::filesystem::exists(trial.string() + ".json"));
}

TEST_F(LdTune, WhatCannotBeIsOneErrorAndLeavesNoModel) {
  expect_failure(tune({}), 2, {"--budget-ms", "--target-smape"});
  expect_failure(tune({"--budget-ms", "20", "--at", "1920"}), 2, {"--at 1920", "1920x1080"});
  expect_failure(tune({"--budget-ms", "20", "loss=smope"}), 2, {"smape"});
  for (const std::string wrong : {"nan", "0", "-5", "inf", "x"})
    expect_failure(tune({"--budget-ms=" + wrong}), 2, {"--budget-ms", "expected a number from 1e-06", wrong});
  expect_failure(tune({"--target-smape", "nan"}), 2, {"expected a number from 1e-06 to 1, found 'nan'"});
  expect_failure(tune({"--budget-ms", "1e-6"}), 1, {"within 1e-06 ms", "the cheapest", "--budget-ms"});
  expect_failure(run_program("ld_tune", {"--data", (folder_ / "none").string(), "--budget-ms", "9", "--out",
                                         out_.string()}),
                 1, {"none"});
  EXPECT_FALSE(std::filesystem::exists(out_));
}

}  // namespace
}  // namespace ld
