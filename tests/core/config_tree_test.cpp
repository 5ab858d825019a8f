#include "core/config_tree.h"

#include <gtest/gtest.h>

#include "core/config_visitor.h"
#include "core/error.h"

namespace ld {
namespace {

struct Inner {
  double rate = 0.5;
  std::vector<std::vector<int64_t>> blocks = {{1, 2}, {3}};
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("rate", rate, at_least(0));
    v.field("blocks", blocks, at_least(1));
  }
};

struct Outer {
  int64_t steps = 10;
  bool shuffle = true;
  std::string loss = "smape";
  std::vector<std::string> features = {"radiance"};
  Inner inner;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("steps", steps, Range{1, 100});
    v.field("shuffle", shuffle);
    v.field("loss", loss, {"smape", "l2"});
    v.field("features", features);
    v.section("inner", inner);
  }
};

Outer parse(const std::string& text, const std::vector<std::string>& overrides = {}) {
  ConfigNode root = parse_config(text, "test.yaml");
  for (const std::string& assignment : overrides) apply_override(root, assignment);
  return config_from_tree<Outer>(root);
}

std::string complaint(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parse(text, overrides);
  } catch (const UsageError& error) {
    EXPECT_EQ(error.exit_code(), 2);
    return error.what();
  }
  return "no complaint";
}

TEST(Config, EmptyTextGivesTheDefaults) {
  const Outer config = parse("");
  EXPECT_EQ(config.steps, 10);
  EXPECT_EQ(config.inner.blocks.size(), 2u);
}

TEST(Config, ReadsEveryType) {
  const Outer config = parse(
      "steps: 7\nshuffle: false\nloss: l2\nfeatures: [a, b]\ninner:\n  rate: 1e-3\n  blocks: [[4, 5], "
      "[6]]\n");
  EXPECT_EQ(config.steps, 7);
  EXPECT_FALSE(config.shuffle);
  EXPECT_EQ(config.loss, "l2");
  EXPECT_EQ(config.features, (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(config.inner.rate, 1e-3);
  EXPECT_EQ(config.inner.blocks, (std::vector<std::vector<int64_t>>{{4, 5}, {6}}));
}

TEST(Config, TheCommandLineBeatsTheFile) {
  const Outer config = parse("steps: 7\n", {"steps=9", "inner.rate=0.25", "features=[x]"});
  EXPECT_EQ(config.steps, 9);
  EXPECT_EQ(config.inner.rate, 0.25);
  EXPECT_EQ(config.features, (std::vector<std::string>{"x"}));
}

TEST(Config, WhatIsWrittenReadsBackTheSame) {
  Outer config;
  config.inner.rate = 0.1;
  config.features = {"two words", "0x", "quote\"d"};
  const std::string text = config_to_yaml(config);
  EXPECT_EQ(config_to_yaml(parse(text)), text);
}

TEST(Config, ComplaintsNameLineKeyAndCure) {
  EXPECT_EQ(complaint("steps: 7\nshufle: true\n"),
            "test.yaml:2: unknown key 'shufle'; did you mean 'shuffle'? known here: steps, shuffle, loss, "
            "features, inner");
  EXPECT_EQ(complaint("inner:\n  rat: 1\n"),
            "test.yaml:2: unknown key 'inner.rat'; did you mean 'inner.rate'? known here: rate, blocks");
  EXPECT_EQ(complaint("steps: 7\niner:\n  rate: 1\n"),
            "test.yaml:2: unknown key 'iner'; did you mean 'inner'? known here: steps, shuffle, loss, "
            "features, inner");
  EXPECT_EQ(complaint("steps: 7\nsteps: 8\n"),
            "test.yaml:2: duplicate key 'steps', first given at test.yaml:1; remove one of them");
  EXPECT_EQ(complaint("steps: many\n"),
            "test.yaml:1: steps: expected a whole number from 1 to 100, found 'many'");
  EXPECT_EQ(complaint("steps: 101\n"),
            "test.yaml:1: steps: expected a whole number from 1 to 100, found '101'");
  EXPECT_EQ(complaint("steps: 1.5\n"),
            "test.yaml:1: steps: expected a whole number from 1 to 100, found '1.5'");
  EXPECT_EQ(complaint("steps:\n"),
            "test.yaml:1: steps: expected a whole number from 1 to 100, found nothing");
  EXPECT_EQ(complaint("inner: 3\n"), "test.yaml:1: inner: expected a map of 'key: value' lines, found '3'");
  EXPECT_EQ(complaint("loss: l3\n"), "test.yaml:1: loss: expected one of smape, l2, found 'l3'");
  EXPECT_EQ(complaint("inner:\n  rate: .nan\n"),
            "test.yaml:2: inner.rate: expected a number of at least 0, found '.nan'");
  EXPECT_EQ(complaint("", {"step=3"}),
            "command line: unknown key 'step'; did you mean 'steps'? known here: steps, shuffle, loss, "
            "features, inner");
  EXPECT_EQ(complaint("", {"steps"}), "command line: expected key.sub=value, found 'steps'");
  EXPECT_EQ(complaint("inner:\n  blocks: [[0]]\n"),
            "test.yaml:2: inner.blocks[0][0]: expected a whole number of at least 1, found '0'");
}

TEST(Config, WhatYamlAllowsAndWeDoNot) {
  EXPECT_NE(complaint("steps: &a 7\n").find("anchor"), std::string::npos);
  EXPECT_NE(complaint("inner: *a\n").find("test.yaml:1"), std::string::npos);
  EXPECT_NE(complaint("steps: !int 7\n").find("tag"), std::string::npos);
  EXPECT_NE(complaint("steps: 7\n---\nsteps: 8\n").find("second document"), std::string::npos);
  EXPECT_NE(complaint("steps: [1\n").find("not valid YAML"), std::string::npos);
  EXPECT_NE(complaint(std::string(4000, '[')).find("test.yaml"), std::string::npos);
  EXPECT_NE(complaint("- 1\n").find("key: value"), std::string::npos);
}

}  // namespace
}  // namespace ld
