#include "tuning/search.h"

#include <gtest/gtest.h>

#include "core/log.h"
#include "models/graphs/network_graph.h"
#include "tests/support/expect_error.h"
#include "tests/tuning/fake_search.h"

namespace ld {
namespace {

class SearchTest : public ::testing::Test {
 protected:
  SearchTest() : space_(candidate_space({}, fake_survey())) { spdlog::set_level(spdlog::level::warn); }
  ~SearchTest() override { spdlog::set_level(spdlog::level::info); }
  std::optional<SearchOutcome> run(const Requirement& requirement, double minutes = 200) {
    return search(space_, requirement, minutes, fake_.tools(space_));
  }
  bool says(const SearchOutcome& outcome, const std::string& text) const {
    return std::any_of(outcome.sentences.begin(), outcome.sentences.end(),
                       [&](const std::string& s) { return s.find(text) != std::string::npos; });
  }
  std::set<std::string> trained() const {
    std::set<std::string> names;
    for (const Trial& trial : fake_.trials) names.insert(trial.name);
    return names;
  }
  std::vector<Candidate> space_;
  FakeTools fake_;
};

const Requirement kBudget = {20.0, std::nullopt};

TEST_F(SearchTest, FindsTheBestWithinTheBudget) {
  fake_.quality = {{"pixel_fine_k9", 0.1}, {"means_fast_k9", 0.2}, {"layer2_small_k9", 0.15}};
  const auto outcome = run(kBudget);
  ASSERT_TRUE(outcome && outcome->chosen);
  const Point& chosen = outcome->points[*outcome->chosen];
  EXPECT_EQ(chosen.candidate.name, "pixel_fine_k9");
  EXPECT_LE(chosen.time.ms, 20);
  EXPECT_TRUE(chosen.unbeaten);
  EXPECT_TRUE(says(*outcome, "Mean and variance of a pixel's samples in place of two layers of samples"));
}

TEST_F(SearchTest, ThoseThatMayBeChosenAreTimedAgainInTurns) {
  fake_.quality = {{"pixel_fine_k9", 0.1}, {"means_fast_k9", 0.2}, {"layer2_small_k9", 0.15}};
  for (const Candidate& candidate : space_)
    if (candidate.config.network.kernel_size != 9) fake_.cost[candidate.name] = 100;  // few candidates
  fake_.cost["means_fast_k9"] = 4;
  fake_.cost["layer2_small_k9"] = 7;
  fake_.slower_again = 1.5;  // 10 and 6 ms, of the best and of its 8 bits, become 15 and 9
  auto outcome = run(kBudget);
  ASSERT_TRUE(outcome && outcome->chosen);
  EXPECT_GE(fake_.in_turns.size(), 3U);
  EXPECT_LE(fake_.in_turns.size(), 6U);
  EXPECT_EQ(outcome->points[*outcome->chosen].candidate.name, "pixel_fine_k9");
  EXPECT_TRUE(says(*outcome, "were timed again, in turns."));
  fake_.slower_again = 2.5;  // 25 and 15
  outcome = run(kBudget);
  ASSERT_TRUE(outcome && outcome->chosen);
  EXPECT_LE(outcome->points[*outcome->chosen].time.ms, 20);
  fake_.slower_again = 100;
  outcome = run(kBudget);
  ASSERT_TRUE(outcome && outcome->chosen);
  EXPECT_TRUE(says(*outcome, "None of them is within 20 ms any more: the fastest is taken."));
}

TEST_F(SearchTest, WhatIsBeyondTheBudgetNeverTrains) {
  for (const Candidate& candidate : space_) fake_.cost[candidate.name] = 31;  // beyond doubt
  fake_.cost["means_fast_k9"] = 15;
  fake_.cost["layer1_fast_k9"] = 25;  // the clock decides
  fake_.eight_bits_time = 0.9;        // 22.5
  fake_.quality["layer1_fast_k9"] = 0.01;
  const auto outcome = run(kBudget);
  ASSERT_TRUE(outcome && outcome->chosen);
  for (const std::string& trial : trained()) EXPECT_EQ(trial.find("layer1"), std::string::npos) << trial;
  EXPECT_EQ(outcome->points[*outcome->chosen].candidate.name, "means_fast_k9");
  EXPECT_TRUE(says(*outcome,
                   "1 of 49 candidates train; 47 are beyond 1.5 times the budget by their graphs, 1 "
                   "beyond it by the clock"))
      << outcome->sentences[0];
}

TEST_F(SearchTest, WhatOnlyEightBitsBringWithinTheBudgetIsChosenInEightBits) {
  for (const Candidate& candidate : space_) fake_.cost[candidate.name] = 31;
  fake_.cost["means_fast_k9"] = 15;
  fake_.cost["layer1_fast_k9"] = 25;  // 15 in 8 bits
  fake_.quality["layer1_fast_k9"] = 0.01;
  auto outcome = run(kBudget);
  ASSERT_TRUE(outcome && outcome->chosen);
  EXPECT_TRUE(says(*outcome, "2 of 49 candidates train, 1 of them for the budget that 8 bits keep"));
  const Point& chosen = outcome->points[*outcome->chosen];
  EXPECT_EQ(chosen.candidate.name, "layer1_fast_k9");
  EXPECT_TRUE(chosen.eight_bits);
  EXPECT_EQ(chosen.time.ms, 15);
  for (const Point& point : outcome->points)
    if (point.candidate.name == "layer1_fast_k9") {
      EXPECT_EQ(point.time.ms, point.eight_bits ? 15 : 25) << point.name;
      EXPECT_EQ(point.name.find(", 8 bits") != std::string::npos, point.eight_bits) << point.name;
    }
  // Where they fail, what was trained for them is no point, and the other is taken.
  fake_.failing_in_eight_bits = true;
  outcome = run(kBudget);
  ASSERT_TRUE(outcome && outcome->chosen);
  EXPECT_TRUE(says(*outcome, "layer1_fast_k9 in 8 bits: dropped, they are too coarse."));
  EXPECT_EQ(outcome->points[*outcome->chosen].candidate.name, "means_fast_k9");
}

TEST_F(SearchTest, ABudgetThatNothingMeetsIsAnErrorThatNamesTheCheapest) {
  for (const Candidate& candidate : space_) fake_.cost[candidate.name] = 100;
  fake_.cost["means_small_k9"] = 50;
  EXPECT_ERROR(run(kBudget), "within 20 ms: the cheapest, means_small_k9, should take 50 ms");
  fake_.predicted = 0.3;  // too optimistic
  EXPECT_ERROR(run(kBudget), "the cheapest, means_small_k9, took 50 ms");
  EXPECT_TRUE(fake_.trials.empty());
}

TEST_F(SearchTest, TheBetterHalfGoesOnFromItsWeightsForTwiceAsLong) {
  fake_.quality = {{"sample_fast_k9", 0.1}, {"layer3_fast_k9", 0.2}};
  const auto outcome = run(kBudget);
  ASSERT_TRUE(outcome);
  double minutes = 0;
  std::map<std::string, size_t> rungs;
  for (const Trial& trial : fake_.trials) {
    minutes += trial.config.run.minutes;
    const size_t at = trial.name.find("_rung");
    if (at == std::string::npos) continue;
    const size_t rung = size_t(trial.name.back() - '0');
    EXPECT_NEAR(trial.config.run.minutes, outcome->plan.rungs[rung].minutes, 1e-12);
    EXPECT_EQ(trial.begins_with,
              rung == 0 ? "" : trial.name.substr(0, at) + "_rung" + std::to_string(rung - 1));
    rungs[trial.name.substr(0, at)] = rung;
  }
  EXPECT_NEAR(minutes, 200, 1e-9);
  EXPECT_EQ(rungs["sample_fast_k9"], outcome->plan.rungs.size() - 1);
  EXPECT_EQ(rungs["layer3_fast_k9"], outcome->plan.rungs.size() - 1);
  EXPECT_EQ(fake_.trials.back().name, "final");
}

TEST_F(SearchTest, FeaturesThatDoNotPayAreDroppedAndSaid) {
  fake_.quality["layer2_fast_k9"] = 0.1;
  fake_.gain = {{"coc", 0.2}, {"motion", 0.001}, {"roughness", -0.01}, {"specular", 0.1}};
  const auto outcome = run(kBudget);
  ASSERT_TRUE(outcome && outcome->chosen);
  EXPECT_EQ(fake_.trials.back().config.network.features,
            (std::vector<std::string>{"radiance", "normal", "depth", "albedo", "specular", "coc", "lens"}));
  EXPECT_TRUE(says(*outcome, "(coc, lens) gains"));
  EXPECT_TRUE(says(*outcome, "Movement and time (motion, time) gains 0.1 % (p = 0.0078): dropped."));
  EXPECT_TRUE(says(*outcome, "Roughness loses"));
}

TEST_F(SearchTest, WithATargetTheCheapestThatReachesItIsFound) {
  for (const Candidate& candidate : space_) fake_.cost[candidate.name] = 50;
  fake_.quality = {{"layer2_fine_k9", 0.01}, {"means_small_k9", 0.04}, {"means_fast_k9", 0.03}};
  fake_.cost["means_small_k9"] = 5;
  fake_.cost["means_fast_k9"] = 10;
  fake_.eight_bits_time = 1;
  const auto outcome = run({std::nullopt, 0.07});
  ASSERT_TRUE(outcome && outcome->chosen);
  EXPECT_EQ(outcome->points[*outcome->chosen].candidate.name, "means_small_k9");
  const auto none = run({std::nullopt, 0.001});
  ASSERT_TRUE(none);
  EXPECT_FALSE(none->chosen);
}

TEST_F(SearchTest, EightBitsAreTakenWhereTheyCostNothingThatIsSure) {
  fake_.eight_bits_error = 1.001;
  auto outcome = run(kBudget);
  EXPECT_TRUE(outcome->points[*outcome->chosen].eight_bits);
  fake_.eight_bits_error = 1.02;
  outcome = run(kBudget);
  EXPECT_FALSE(outcome->points[*outcome->chosen].eight_bits);
  EXPECT_TRUE(says(*outcome, "8 bits take 6 ms in place of 10"));
}

TEST_F(SearchTest, AFailedTrainingIsNoCandidateAnyMore) {
  fake_.quality["layer2_fast_k9"] = 0.1;
  fake_.failing = {"layer2_fast_k9_rung0"};
  const auto outcome = run(kBudget);
  ASSERT_TRUE(outcome);
  EXPECT_TRUE(says(*outcome, "layer2_fast_k9: dropped, its training failed: it diverged."));
  for (const Point& point : outcome->points) EXPECT_NE(point.candidate.name, "layer2_fast_k9");
  for (const Candidate& candidate : space_) fake_.failing.insert(candidate.name + "_rung0");
  EXPECT_ERROR(run(kBudget), "no candidate could be trained");
}

TEST_F(SearchTest, AStopEndsItAndTheSameQuestionsFollowAgain) {
  ASSERT_TRUE(run(kBudget));
  const std::vector<Trial> whole = fake_.trials;
  fake_.trials.clear();
  fake_.stop_after = 5;
  EXPECT_FALSE(run(kBudget));
  ASSERT_EQ(fake_.trials.size(), 5);
  for (size_t i = 0; i < 5; ++i) EXPECT_EQ(fake_.trials[i].name, whole[i].name);
}

TEST(TuningCandidates, OneSampleAPixelLeavesTheMean) {
  for (const Candidate& candidate : candidate_space({}, fake_survey({}, 1)))
    EXPECT_EQ(candidate.network, "means");
}

TEST(TuningCandidates, BeginWithTheReleasedWeightsOfTheirNetwork) {
  std::map<std::string, std::string> begins;
  for (const Candidate& candidate : candidate_space({}, fake_survey())) EXPECT_EQ(candidate.config.init, "");
  TrainConfig base;  // as configs/samples_fast.yaml has them
  base.network.demodulation = "albedo";
  base.network.logit_bound = 8;
  base.network.rejection = true;
  for (const Candidate& candidate : candidate_space(base, fake_survey()))
    if (!candidate.config.init.empty()) begins[candidate.name] = candidate.config.init;
  EXPECT_EQ(begins, (std::map<std::string, std::string>{{"layer2_fast_k9", "common_fast"},
                                                        {"means_fine_k9", "means"},
                                                        {"pixel_fine_k9", "common_fine"},
                                                        {"pixel_small_k5", "common_small"},
                                                        {"pixel_tiny_k5", "common_tiny"},
                                                        {"pyramid_fine_k9", "pyramid_fine"}}));
  for (const Candidate& candidate : candidate_space(base, fake_survey({"albedo"})))
    EXPECT_EQ(candidate.config.init, "") << candidate.name << " does not demodulate";
}

TEST(TuningCandidates, AreNetworksOfTheFeaturesThatVary) {
  for (const Candidate& candidate : candidate_space({}, fake_survey({"lens", "coc", "albedo"}))) {
    const NetworkConfig& network = candidate.config.network;
    EXPECT_EQ(std::count(network.features.begin(), network.features.end(), "lens"), 0);
    EXPECT_EQ(network.demodulation, "none");
    EXPECT_GT(parameters(network_graph(network)).size(), 0) << candidate.name;  // the sizes fit together
  }
}

}  // namespace
}  // namespace ld
