#include "import/channel_pattern.h"

#include <gtest/gtest.h>

namespace ld {
namespace {

TEST(ChannelPattern, FitsWholeNames) {
  EXPECT_TRUE(match_pattern("R", "R"));
  EXPECT_FALSE(match_pattern("R", "R2"));
  EXPECT_FALSE(match_pattern("R", ""));
  EXPECT_TRUE(match_pattern("*", ""));
  EXPECT_TRUE(match_pattern("*.Combined.R", "ViewLayer.Combined.R"));
  EXPECT_TRUE(match_pattern("*.Combined.R", "A.b.Combined.R"));
  EXPECT_FALSE(match_pattern("*.Combined.R", "Combined.R"));
  EXPECT_FALSE(match_pattern("*.Combined.R", "ViewLayer.Combined.R2"));
  EXPECT_EQ(match_pattern("R", "R")->sample, -1);
}

TEST(ChannelPattern, ReadsTheNumbersOfSamples) {
  EXPECT_EQ(match_pattern("s{sample}", "s012")->sample, 12);
  EXPECT_EQ(match_pattern("*{sample}.R", "sample7.R")->sample, 7);
  EXPECT_EQ(match_pattern("s{sample}.*", "s3.color.R")->sample, 3);
  EXPECT_FALSE(match_pattern("s{sample}", "s"));
  EXPECT_FALSE(match_pattern("s{sample}", "s1x"));
  EXPECT_FALSE(match_pattern("s{sample}", "s99999999999999999999"));
}

TEST(ChannelPattern, AlternativesAndLayers) {
  EXPECT_EQ(pattern_alternatives("A | B.X | C"), (std::vector<std::string>{"A", "B.X", "C"}));
  EXPECT_EQ(pattern_alternatives("A"), std::vector<std::string>{"A"});
  EXPECT_EQ(with_layer("{layer}.Z | {layer}.V", "*"), "*.Z | *.V");
  EXPECT_EQ(with_layer("{layer}.Z", "a{layer}"), "a{layer}.Z");
}

}  // namespace
}  // namespace ld
