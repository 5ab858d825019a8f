// ld_bench from the command line, small: that it runs and says all that it must, not how fast anything is.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <set>

#include "core/json_text.h"
#include "models/check_network.h"
#include "tests/benchmark/xml_check.h"
#include "tests/support/run_program.h"
#include "weights/released.h"

namespace ld {
namespace {

const std::string kConfigs = std::string(LD_SOURCE_DIR) + "/configs";

nlohmann::json run_bench(const TemporaryFolder& folder, std::vector<std::string> arguments) {
  const std::string json = (folder / "result.json").string();
  for (const std::string& more : {std::string("--quick"), std::string("--configs"), kConfigs,
                                  std::string("--json"), json, std::string("--out"), folder.path().string()})
    arguments.push_back(more);
  const ProgramResult result = run_program("ld_bench", arguments);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  return parse_json(read_file(json), json);
}

std::set<std::string> check_rows(const nlohmann::json& rows) {
  std::set<std::string> names;
  for (const auto& row : rows) {
    names.insert(row.at("name"));
    for (const char* key : {"ms", "baseline_ms", "speedup", "sgemm_share", "multiply_adds"})
      EXPECT_GT(row.at(key).get<double>(), 0) << row;
    EXPECT_GE(row.at("peak_mb").get<double>(), 0) << row;  // 0 where the freed memory of before was enough
    EXPECT_GE(row.at("repeats").get<int>(), 1) << row;
    EXPECT_GE(row.at("baseline_repeats").get<int>(), 1) << row;
  }
  return names;
}

TEST(LdBench, OpsGivesEveryRow) {
  const TemporaryFolder folder;
  const auto json = run_bench(folder, {"ops"});
  const std::set<std::string> expected = {"reducer_forward",  "reducer_train",   "partition_forward",
                                          "partition_train",  "splat17_forward", "splat17_train",
                                          "gather17_forward", "gather17_train"};
  EXPECT_EQ(check_rows(json.at("rows")), expected);
  EXPECT_GT(json.at("sgemm_gflops").get<double>(), 0);
  EXPECT_NE(read_file(folder / "ops.md").find("| splat17_train"), std::string::npos);
}

TEST(LdBench, NetworkGivesEveryRowTableAndFigure) {
  const TemporaryFolder folder;
  const auto json = run_bench(folder, {"network"});
  std::set<std::string> expected = {"layer_train_128", "layer_history_train_128", "optimized_train_128"};
  for (const std::string& name : network_names()) expected.insert(name + "_infer_256");
  EXPECT_EQ(check_rows(json.at("rows")), expected);
  std::set<std::string> sizes;
  for (const auto& row : json.at("sizes")) {
    sizes.insert(row.at("name"));
    for (const char* key :
         {"ms", "repeats", "multiply_adds", "bytes", "sgemm_share", "arithmetic_ms", "memory_ms"})
      EXPECT_GT(row.at(key).get<double>(), 0) << row;
    EXPECT_EQ(row.at("perfect_ms").get<double>(),
              std::max(row.at("arithmetic_ms").get<double>(), row.at("memory_ms").get<double>()));
  }
  EXPECT_EQ(sizes.size(), 2 * (network_names().size() + released_models().size()));
  EXPECT_EQ(sizes.count("common_fast_48x33"), 1);
  EXPECT_GT(json.at("memory_gb_per_s").get<double>(), 0);
  EXPECT_EQ(json.at("samples").size(), 2);
  EXPECT_EQ(json.at("stages").size(), 12);
  EXPECT_EQ(json.at("cost").size(), 2 * network_names().size());  // at two sample counts
  for (const char* name : {"cost", "stages", "samples"}) {
    EXPECT_EQ(xml_fault(read_file(folder / (std::string(name) + ".svg"))), "") << name;
    EXPECT_NE(read_file(folder / (std::string(name) + ".md")).find("layer"), std::string::npos) << name;
  }
}

TEST(LdBench, ConfigSaysWhatANetworkCosts) {
  const TemporaryFolder folder;
  const std::string json = (folder / "result.json").string();
  const ProgramResult result = run_program(
      "ld_bench",
      {"config", kConfigs + "/quick.yaml", kConfigs + "/quick_optimized.yaml", "--quick", "--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const auto costs = parse_json(read_file(json), json);
  ASSERT_EQ(costs.size(), 2);
  for (const auto& cost : costs) {
    for (const char* key : {"parameters", "multiply_adds_per_pixel", "inference_ms", "training_ms"})
      EXPECT_GT(cost.at(key).get<double>(), 0) << cost;
    for (const char* key : {"inference_peak_mb", "training_peak_mb"})
      EXPECT_GE(cost.at(key).get<double>(), 0) << cost;
  }
  EXPECT_LT(costs[1].at("multiply_adds_per_pixel"), costs[0].at("multiply_adds_per_pixel"));
}

TEST(LdBench, OnlyPicksRowsAndNamesAreChecked) {
  const TemporaryFolder folder;
  const auto json = run_bench(folder, {"ops", "--only", "gather17_forward"});
  EXPECT_EQ(check_rows(json.at("rows")), std::set<std::string>{"gather17_forward"});
  expect_failure(
      run_program("ld_bench", {"ops", "--quick", "--configs", kConfigs, "--only", "gather_forward"}), 2,
      {"no such row", "gather17_forward"});
  const auto sizes = run_bench(folder, {"network", "--only", "layer_32x32"});
  EXPECT_TRUE(sizes.at("rows").empty());
  EXPECT_EQ(sizes.at("sizes").size(), 1);
  EXPECT_FALSE(sizes.contains("stages"));
  const auto stages = run_bench(folder, {"network", "--only", "stages"});
  EXPECT_EQ(stages.at("stages").size(), 12);
  EXPECT_FALSE(stages.contains("sizes"));
  expect_failure(run_program("ld_bench", {}), 2, {"subcommand"});
}

}  // namespace
}  // namespace ld
