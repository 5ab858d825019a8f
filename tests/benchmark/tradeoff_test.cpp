// The trade-off of speed and accuracy: what counts as beaten, the figure, and the command on a tiny data set.
#include "benchmark/tradeoff.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/json_text.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "metrics/metric.h"
#include "tests/benchmark/xml_check.h"
#include "tests/support/expect_error.h"
#include "tests/support/run_program.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

const std::string kWeights = std::string(LD_SOURCE_DIR) + "/tests/fixtures/before_simd/layer.safetensors";

/// A point whose scores are all `error`.
TradeoffPoint point(const std::string& name, double error, double ms, double peak_mb) {
  TradeoffPoint result;
  result.name = name;
  result.scores.assign(metrics().size(), error);
  result.ms = ms;
  result.peak_mb = peak_mb;
  return result;
}

std::string unbeaten(std::vector<TradeoffPoint> points, size_t metric = 0) {
  mark_unbeaten(points, metric);
  std::string names;
  for (const TradeoffPoint& p : points)
    if (p.unbeaten) names += p.name;
  return names;
}

TEST(Tradeoff, OnlyWhatIsWorseInSomethingAndBetterInNothingIsBeaten) {
  EXPECT_EQ(unbeaten({point("a", 1, 10, 10), point("b", 2, 5, 10), point("c", 2, 10, 10)}), "ab");
  EXPECT_EQ(unbeaten({point("a", 1, 10, 10), point("b", 2, 20, 5)}), "ab");  // memory counts
  EXPECT_EQ(unbeaten({point("a", 1, 1, 1), point("b", 1, 1, 1)}), "ab");     // equals beat nobody
  EXPECT_EQ(unbeaten({point("a", std::nan(""), 1, 1), point("b", 2, 5, 5)}), "b");
}

TEST(Tradeoff, OtherProgramsAreNotMarkedAndBeatNobody) {
  TradeoffPoint other = point("o", 0.5, 1, 1);
  other.other_program = true;
  EXPECT_EQ(unbeaten({point("a", 1, 10, 10), other}), "a");
}

TEST(Tradeoff, MoreIsBetterWhereTheMetricSaysSo) {
  const auto psnr = size_t(&find_metric("psnr") - metrics().data());
  EXPECT_EQ(unbeaten({point("a", 30, 10, 10), point("b", 20, 10, 10)}, psnr), "a");
}

Tradeoff two_points() {
  Tradeoff tradeoff;
  tradeoff.metric = "smape";
  tradeoff.noisy.assign(metrics().size(), 0.9);
  tradeoff.blur.assign(metrics().size(), 0.15);
  tradeoff.points = {point("a<b", 0.1, 10, 50), point("c", 0.2, 20, 40)};
  mark_unbeaten(tradeoff.points, 1);
  return tradeoff;
}

TEST(Tradeoff, TheFigureIsWellFormedAndNamesEverything) {
  const std::string svg = to_svg(figure(two_points()));
  EXPECT_EQ(xml_fault(svg), "");
  for (const char* words : {"a&lt;b", ">c<", "best blur: 0.15", "noisy: 0.9", "no other model beats it"})
    EXPECT_NE(svg.find(words), std::string::npos) << words;
}

TEST(Tradeoff, AFigureOfWhatIsNoNumberIsAnError) {
  Tradeoff broken = two_points();
  broken.points[0].ms = 0;
  EXPECT_ERROR(to_svg(figure(broken)), "'a<b' has a number that its axes cannot show");
  broken.points.clear();
  EXPECT_ERROR(to_svg(figure(broken)), "has no marks");
}

class TradeoffCommand : public ::testing::Test {
 protected:
  TradeoffCommand() : data_(folder_ / "data") {
    write_tiny_dataset(data_, 3);
    for (const ManifestFrame& frame : read_manifest(data_).frames)
      if (frame.split == "validation") validation_.push_back(frame.name);
    // "Another program" that returns the reference.
    for (const std::string& name : validation_)
      write_image(folder_ / "other" / (name + ".exr"), read_image(data_ / (name + ".reference.exr")));
  }
  void write_cost(int threads) {
    nlohmann::json cost = {{"threads", threads}, {"peak_mb", 3.5}, {"seconds", nlohmann::json::object()}};
    for (const std::string& name : validation_) cost["seconds"][name] = 0.25;
    write_file_atomically(folder_ / "other/cost.json", cost.dump());
  }
  ProgramResult run(const std::vector<std::string>& more) {
    std::vector<std::string> arguments = {"tradeoff",  "--data", data_.string(), "--split", "validation",
                                          "--threads", "1",      "--repeats",    "1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program("ld_bench", arguments);
  }
  std::string other() const { return "other=" + (folder_ / "other").string(); }

  TemporaryFolder folder_;
  std::filesystem::path data_;
  std::vector<std::string> validation_;
};

TEST_F(TradeoffCommand, MeasuresModelsBesideAnotherProgram) {
  write_cost(1);
  const std::string json = (folder_ / "t.json").string();
  const ProgramResult result = run({"--model", "layer=" + kWeights, "--images", other(), "--out",
                                    folder_.path().string(), "--json", json});
  ASSERT_EQ(result.exit_code, 0) << result.output;
  const auto points = parse_json(read_file(json), json).at("points");
  ASSERT_EQ(points.size(), 2);
  EXPECT_GT(points[0].at("ms").get<double>(), 0);
  EXPECT_GT(points[0].at("multiply_adds_per_pixel").get<double>(), 0);
  EXPECT_GT(points[0].at("scores").at("smape").get<double>(), 0);
  EXPECT_EQ(points[1].at("ms"), 250);
  EXPECT_EQ(points[1].at("peak_mb"), 3.5);
  EXPECT_EQ(points[1].at("scores").at("smape"), 0);  // it is the reference
  EXPECT_TRUE(points[0].at("unbeaten").get<bool>());
  const auto all = parse_json(read_file(json), json);
  ASSERT_GT(all.at("spp").get<int>(), 1);
  ASSERT_EQ(run({"--model", "layer=" + kWeights, "--samples", "1", "--json", json}).exit_code, 0);
  const auto one = parse_json(read_file(json), json);
  EXPECT_EQ(one.at("spp"), 1);
  EXPECT_GT(one.at("noisy").at("smape").get<double>(), all.at("noisy").at("smape").get<double>());
  EXPECT_FALSE(points[1].at("unbeaten").get<bool>());
  EXPECT_EQ(xml_fault(read_file(folder_ / "tradeoff.svg")), "");
  EXPECT_NE(read_file(folder_ / "tradeoff.md").find("| layer"), std::string::npos);
}

TEST_F(TradeoffCommand, WhatDoesNotBelongTogetherIsRefused) {
  expect_failure(run({}), 2, {"nothing to measure", "--model"});
  expect_failure(run({"--images", other()}), 1, {"cost.json"});
  write_cost(4);
  expect_failure(run({"--images", other()}), 1, {"cost.json", "on 4 threads", "uses 1"});
  write_file_atomically(folder_ / "other/cost.json", "{}");
  expect_failure(run({"--images", other()}), 1, {"cost.json", "seconds"});
  expect_failure(run({"--images", other(), "--metric", "smap"}), 2, {"smape"});
}

}  // namespace
}  // namespace ld
