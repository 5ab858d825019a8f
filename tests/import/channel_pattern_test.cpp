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

/// The definition: a star takes any number of characters, {sample} all digits that are there.
bool matches_by_definition(const std::string& pattern, const std::string& text) {
  if (pattern.empty()) return text.empty();
  if (pattern[0] == '*') {
    for (size_t taken = 0; taken <= text.size(); ++taken)
      if (matches_by_definition(pattern.substr(1), text.substr(taken))) return true;
    return false;
  }
  if (pattern[0] == '{') {
    const size_t digits = std::min(text.find_first_not_of("0123456789"), text.size());
    return digits > 0 && matches_by_definition(pattern.substr(8), text.substr(digits));
  }
  return !text.empty() && text[0] == pattern[0] && matches_by_definition(pattern.substr(1), text.substr(1));
}

std::vector<std::string> sequences(const std::vector<std::string>& elements, size_t longest) {
  std::vector<std::string> all = {""};
  for (size_t begin = 0, length = 1; length <= longest; ++length) {
    const size_t end = all.size();
    for (; begin < end; ++begin)
      for (const std::string& element : elements) all.push_back(all[begin] + element);
  }
  return all;
}

TEST(ChannelPattern, IsWhatTheDefinitionSays) {
  for (const std::string& pattern : sequences({"*", "{sample}", "a", "1"}, 5))
    for (const std::string& text : sequences({"a", "1"}, 5))
      ASSERT_EQ(match_pattern(pattern, text).has_value(), matches_by_definition(pattern, text))
          << pattern << " " << text;
}

TEST(ChannelPattern, ManyStarsTakeNoTime) {
  std::string stars, text(200, 'a');
  for (int i = 0; i < 100; ++i) stars += "*a";
  EXPECT_TRUE(match_pattern(stars, text));
  EXPECT_FALSE(match_pattern(stars + "b", text));  // the recursive definition takes longer than the sun lasts
}

TEST(ChannelPattern, AlternativesAndLayers) {
  EXPECT_EQ(pattern_alternatives("A | B.X | C"), (std::vector<std::string>{"A", "B.X", "C"}));
  EXPECT_EQ(pattern_alternatives("A"), std::vector<std::string>{"A"});
  EXPECT_EQ(with_layer("{layer}.Z | {layer}.V", "*"), "*.Z | *.V");
  EXPECT_EQ(with_layer("{layer}.Z", "a{layer}"), "a{layer}.Z");
}

}  // namespace
}  // namespace ld
