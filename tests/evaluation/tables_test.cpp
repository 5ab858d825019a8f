#include "evaluation/tables.h"

#include <gtest/gtest.h>

#include <limits>
#include <sstream>

#include "metrics/sequence_meter.h"
#include "tests/support/special_values.h"

namespace ld {
namespace {

Evaluation example() {
  Evaluation evaluation;
  evaluation.data = "data/test";
  evaluation.split = "test";
  evaluation.methods.resize(3);
  evaluation.methods[0].name = "noisy";
  evaluation.methods[0].frames = {{"f0", {0.25, 0.125, 0.5, 20}, 0, {}},
                                  {"f1", {0.75, 0.25, 0.75, 30}, 0, {}}};
  evaluation.methods[1].name = "blur";
  evaluation.methods[1].frames = {{"f0", {0.125, 0.1, 0.6, 25}, 0, {}}, {"f1", {0.25, 0.2, 0.8, 35}, 0, {}}};
  evaluation.methods[1].sigmas = {2, 1, 0.5, 8};
  evaluation.methods[2].name = "a|b, \"c\"";
  evaluation.methods[2].frames = {{"f0", {4.3e13, 0.00001, 1, kInfinite}, 0, 0.5},
                                  {"f1", {kNan, kNan, kNan, kNan}, 7, 1.5}};
  return evaluation;
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> result;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) result.push_back(line);
  return result;
}

TEST(Tables, MarkdownMeansReadAsATable) {
  const std::vector<std::string> table = lines(markdown_means(example()));
  ASSERT_GE(table.size(), 12U);
  EXPECT_EQ(table[0], "| method    | relMSE |  SMAPE |   SSIM |  PSNR | s/frame |");
  EXPECT_EQ(table[1], "| :-------- | -----: | -----: | -----: | ----: | ------: |");
  EXPECT_EQ(table[2], "| noisy     | 0.5000 | 0.1875 | 0.6250 | 25.00 |       - |");
  EXPECT_EQ(table[3], "| blur      | 0.1875 | 0.1500 | 0.7000 | 30.00 |       - |");
  EXPECT_EQ(table[4], "| a\\|b, \"c\" |    nan |    nan |    nan |   nan |   1.000 |");
  EXPECT_EQ(
      table[6],
      "- relMSE: lower is better; mean over pixels and channels of (d - r)^2 / (r^2 + 0.0001); on linear "
      "radiance, epsilon 0.0001");
  EXPECT_EQ(table[9].substr(0, 25), "- PSNR: higher is better;");
  EXPECT_EQ(table[10],
            "- blur: Gaussian, its width chosen for each metric: 2 px for relMSE, 1 px for SMAPE, 0.5 px for "
            "SSIM (end of the "
            "sweep), 8 px for PSNR (end of the sweep)");
  EXPECT_NE(table[11].find("7 values are NaN or infinite"), std::string::npos);
}

TEST(Tables, MarkdownFramesHasARowForEachFrameAndMethod) {
  const std::vector<std::string> table = lines(markdown_frames(example()));
  ASSERT_EQ(table.size(), 8U);
  EXPECT_EQ(table[2], "| f0    | noisy     |    0.2500 |    0.1250 | 0.5000 | 20.00 |       - |");
  // Neither digits without end nor a number that rounds to nothing.
  EXPECT_EQ(table[4], "| f0    | a\\|b, \"c\" | 4.300e+13 | 1.000e-05 | 1.0000 |   inf |   0.500 |");
  EXPECT_EQ(table[7], "| f1    | a\\|b, \"c\" |       nan |       nan |    nan |   nan |   1.500 |");
}

TEST(Tables, CsvHoldsFullPrecisionMeansAndQuotes) {
  Evaluation evaluation = example();
  evaluation.methods[0].frames[0].values[0] = 0.1 + 0.2;
  const std::vector<std::string> table = lines(to_csv(evaluation));
  ASSERT_EQ(table.size(), 16U);
  EXPECT_EQ(table[0], "method,frame,relmse,smape,ssim,psnr,seconds,not_finite");
  EXPECT_EQ(table[1], "noisy,f0,0.30000000000000004,0.125,0.5,20,,0");
  EXPECT_EQ(table[8], "blur,mean,0.1875,0.15000000000000002,0.7,30,,0");
  // 12.7062 deviations of the mean (0.0625, 0.05, 0.1 and 5) to either side.
  EXPECT_EQ(table[9].substr(0, 20), "blur,ci95_low,-0.606");
  EXPECT_EQ(table[10].substr(0, 20), "blur,ci95_high,0.981");
  EXPECT_EQ(table[11], "\"a|b, \"\"c\"\"\",f0,43000000000000,1e-05,1,inf,0.5,0");
  EXPECT_EQ(table[13], "\"a|b, \"\"c\"\"\",mean,nan,nan,nan,nan,1,7");
  EXPECT_EQ(table[14], "\"a|b, \"\"c\"\"\",ci95_low,,,,,,0");
}

TEST(Tables, MarkdownIntervalsStandBesideTheMeans) {
  const std::vector<std::string> table = lines(markdown_intervals(example()));
  EXPECT_EQ(table[0], "95 % confidence intervals of these means over 2 frames (Student's t):");
  EXPECT_EQ(table[5].substr(0, 32), "| blur      | -0.6066 .. 0.9816 ");
  EXPECT_EQ(table[6],
            "| a\\|b, \"c\" |                 - |                 - |                 - |               - |");
}

TEST(Tables, MarkdownComparisonNamesTheBaselineAndSaysWhenFramesAreTooFew) {
  Evaluation evaluation = example();
  evaluation.baseline = "noisy";
  const std::string text = markdown_comparison(evaluation);
  EXPECT_EQ(text.find("In pairs with noisy: method - noisy, mean over 2 frames"), 0U);
  const std::vector<std::string> table = lines(text);
  EXPECT_EQ(table[4], "| relMSE | blur      |    -0.3125 | -2.6949 .. 2.0699 |      2 |     0 | 0.5000 |");
  EXPECT_EQ(table[5].substr(0, 35), "| relMSE | a\\|b, \"c\" |        nan |");
  EXPECT_EQ(table.back(),
            "- 2 frames are too few: the signed-rank test cannot come below 0.05 with fewer than 6");
}

TEST(Tables, ComparisonCsvLeavesCellsEmptyThatDoNotExist) {
  Evaluation evaluation = example();
  evaluation.baseline = "noisy";
  const std::vector<std::string> table = lines(comparison_csv(evaluation));
  ASSERT_EQ(table.size(), 9U);
  EXPECT_EQ(table[0],
            "baseline,method,metric,frames,mean_difference,ci95_low,ci95_high,better,worse,equal,p");
  EXPECT_EQ(table[1].substr(0, 28), "noisy,blur,relmse,2,-0.3125,");
  EXPECT_EQ(table[1].substr(table[1].size() - 10), ",2,0,0,0.5");
  EXPECT_EQ(table[5], "noisy,\"a|b, \"\"c\"\"\",relmse,2,,,,0,2,0,");
}

TEST(Tables, TheFloorStandsBelowTheMethods) {
  Evaluation evaluation = example();
  evaluation.floor =
      MethodScores{"reference's floor",
                   {{"f0", {0.001, 0.01, 0.99, 50}, 0, {}}, {"f1", {0.003, 0.01, 0.99, kInfinite}, 0, {}}},
                   {}};
  const std::vector<std::string> means = lines(markdown_means(evaluation));
  EXPECT_EQ(means[5].substr(0, 39), "| reference's floor | 0.0020 | 0.0100 |");
  EXPECT_NE(means[5].find("| 0.9900 |   inf |       - |"), std::string::npos) << means[5];
  EXPECT_EQ(means.back(), "- reference's floor: " + floor_text());
  EXPECT_NE(markdown_intervals(evaluation).find("| reference's floor | "), std::string::npos);
  EXPECT_NE(markdown_frames(evaluation).find("| f1    | reference's floor |"), std::string::npos);
  EXPECT_EQ(lines(markdown_comparison(evaluation)).back(),
            "- reference's floor: relMSE 0.0020, SMAPE 0.0100, SSIM 0.9900, PSNR inf");
  const auto json = nlohmann::json::parse(to_json(evaluation).dump());
  EXPECT_EQ(json["floor"]["mean"]["relmse"], 0.002);
  EXPECT_TRUE(json["floor"]["mean"]["psnr"].is_null());
  EXPECT_EQ(json["floor"]["frames"][0]["psnr"], 50);
  EXPECT_EQ(json["methods"].size(), 3U);
  EXPECT_FALSE(to_json(example()).contains("floor"));
  EXPECT_EQ(to_csv(evaluation), to_csv(example()));
}

TEST(Tables, WhatDoesNotApplyIsNoZeroAndNoScore) {
  Evaluation evaluation = example();
  evaluation.of_sequences = true;
  for (MethodScores& method : evaluation.methods) {
    method.frames[0].applies = {false, true, true, false};
    method.frames[1].applies = {true, true, true, false};
  }
  EXPECT_EQ(evaluation.method("noisy").mean(0), 0.75);
  const std::vector<std::string> means = lines(markdown_means(evaluation));
  EXPECT_EQ(means[2], "| noisy     | 0.7500 | 0.1875 | 0.6250 |    - |       - |");
  EXPECT_NE(markdown_intervals(evaluation).find("over 2 sequences"), std::string::npos);
  EXPECT_NE(markdown_comparison(evaluation).find("2 sequences are too few"), std::string::npos);
  const auto json = nlohmann::json::parse(to_json(evaluation).dump());
  EXPECT_EQ(json["unit"], "sequence");
  EXPECT_TRUE(json["methods"]["noisy"]["mean"]["psnr"].is_null());
  EXPECT_TRUE(json["comparison"]["methods"]["noisy"]["psnr"]["mean_difference"].is_null());
}

TEST(Tables, FormulasOfAllMetrics) {
  const std::vector<std::string> text = lines(formulas_text());
  ASSERT_EQ(text.size(), 1 + metrics().size() + further_metrics().size() + sequence_measures().size());
  EXPECT_EQ(text[1].find("relMSE = mean over pixels and channels of (d - r)^2 / (r^2 + 0.0001)"), 0U);
  EXPECT_EQ(text[2].find("SMAPE = mean over pixels and channels of |d - r| / (|d| + |r| + 0.01)"), 0U);
  EXPECT_NE(text[3].find("C1 = 0.01^2, C2 = 0.03^2"), std::string::npos);
  EXPECT_NE(text[4].find("10 log10"), std::string::npos);
}

TEST(Tables, JsonHasTheAgreedShapeAndNullForWhatIsNoNumber) {
  // Through text, as a reader would get it.
  const auto json = nlohmann::json::parse(to_json(example()).dump(2));
  EXPECT_EQ(json["relmse_epsilon"], 1e-4);
  EXPECT_EQ(json["smape_epsilon"], 0.01);
  EXPECT_EQ(json["frame_count"], 2);
  EXPECT_EQ(json["split"], "test");
  EXPECT_EQ(json["metrics"]["ssim"]["better"], "higher");
  EXPECT_EQ(json["metrics"]["relmse"]["formula"],
            "mean over pixels and channels of (d - r)^2 / (r^2 + 0.0001)");
  EXPECT_EQ(json["confidence"], 0.95);
  EXPECT_EQ(json["methods"].size(), 3U);
  EXPECT_NEAR(json["methods"]["blur"]["interval"]["psnr"][1].get<double>(), 30 + 12.7062047 * 5, 1e-5);
  EXPECT_TRUE(json["methods"]["a|b, \"c\""]["interval"]["psnr"].is_null());
  EXPECT_EQ(json["comparison"]["baseline"], "a|b, \"c\"");
  EXPECT_EQ(json["comparison"]["too_few_frames"], true);
  EXPECT_EQ(json["comparison"]["methods"]["blur"]["psnr"]["better"], 1);
  EXPECT_TRUE(json["comparison"]["methods"]["blur"]["psnr"]["p"].is_null());
  EXPECT_EQ(json["methods"]["noisy"]["mean"],
            (nlohmann::json{{"relmse", 0.5}, {"smape", 0.1875}, {"ssim", 0.625}, {"psnr", 25}}));
  EXPECT_EQ(json["methods"]["noisy"]["frames"][1]["name"], "f1");
  EXPECT_EQ(json["methods"]["noisy"]["frames"][1]["relmse"], 0.75);
  EXPECT_EQ(json["methods"]["blur"]["sigma"]["relmse"], 2);
  EXPECT_FALSE(json["methods"]["noisy"].contains("seconds"));
  EXPECT_FALSE(json["methods"]["noisy"].contains("sigma"));
  const auto& broken = json["methods"]["a|b, \"c\""];
  EXPECT_TRUE(broken["frames"][0]["psnr"].is_null());
  EXPECT_EQ(broken["frames"][0]["relmse"], 4.3e13);
  EXPECT_TRUE(broken["mean"]["relmse"].is_null());
  EXPECT_TRUE(broken["mean"].contains("relmse"));
  EXPECT_EQ(broken["not_finite"], 7);
  EXPECT_EQ(broken["frames"][1]["not_finite"], 7);
  EXPECT_EQ(broken["seconds"], 1.0);
}

}  // namespace
}  // namespace ld
