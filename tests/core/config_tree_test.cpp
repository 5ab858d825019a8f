#include "core/config_tree.h"

#include <gtest/gtest.h>

#include "core/config_visitor.h"
#include "core/error.h"
#include "tests/support/expect_error.h"

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
  EXPECT_EQ(complaint("loss: l3\n"),
            "test.yaml:1: loss: expected one of smape, l2 (did you mean 'l2'?), found 'l3'");
  EXPECT_EQ(complaint("inner:\n  rate: .nan\n"),
            "test.yaml:2: inner.rate: expected a number of at least 0, found '.nan'");
  EXPECT_EQ(complaint("", {"step=3"}),
            "command line: unknown key 'step'; did you mean 'steps'? known here: steps, shuffle, loss, "
            "features, inner");
  EXPECT_EQ(complaint("", {"steps"}), "command line: expected key.sub=value, found 'steps'");
  EXPECT_EQ(complaint("inner:\n  blocks: [[0]]\n"),
            "test.yaml:2: inner.blocks[0][0]: expected a whole number of at least 1, found '0'");
}

struct Place {
  std::string path;
  double weight = 1;
  template <class Visitor>
  void visit(Visitor& v) {
    v.field("path", path);
    v.field("weight", weight, at_least(0));
  }
};

struct Places {
  std::vector<Place> list = {{"home", 1}};
  std::vector<std::string> names = {"a"};
  template <class Visitor>
  void visit(Visitor& v) {
    v.sections("list", list);
    v.field_or_word("names", names, "auto");
  }
};

Places places(const std::string& text) {
  return config_from_tree<Places>(parse_config(text, "test.yaml"));
}

TEST(Config, ListsOfSections) {
  EXPECT_EQ(places("").list.size(), 1u);
  EXPECT_EQ(places("list: []\n").list.size(), 0u);
  const Places two = places("list:\n  - path: x\n    weight: 2.5\n  - {path: y/z}\n");
  ASSERT_EQ(two.list.size(), 2u);
  EXPECT_EQ(two.list[0].path, "x");
  EXPECT_EQ(two.list[0].weight, 2.5);
  EXPECT_EQ(two.list[1].path, "y/z");
  EXPECT_EQ(two.list[1].weight, 1);
  const std::string written = config_to_yaml(two);
  EXPECT_EQ(written, "list:\n  - path: x\n    weight: 2.5\n  - path: y/z\n    weight: 1\nnames: [a]\n");
  EXPECT_EQ(config_to_yaml(places(written)), written);
  EXPECT_EQ(config_to_yaml(places("list: []\n")), "list: []\nnames: [a]\n");
  EXPECT_EQ(error_text([] { places("list: 3\n"); }), "test.yaml:1: list: expected a list of maps, found '3'");
  EXPECT_EQ(
      error_text([] { places("list:\n  - path: x\n  - wheight: 1\n"); }),
      "test.yaml:3: unknown key 'list[1].wheight'; did you mean 'list[1].weight'? known here: path, weight");
  EXPECT_EQ(error_text([] { places("list: [x]\n"); }),
            "test.yaml:1: list[0]: expected a map of 'key: value' lines, found 'x'");
}

TEST(Config, AListOrAWord) {
  EXPECT_EQ(places("names: auto\n").names, std::vector<std::string>{"auto"});
  EXPECT_EQ(places("names: [x, y]\n").names, (std::vector<std::string>{"x", "y"}));
  EXPECT_EQ(config_to_yaml(places("{list: [], names: auto}\n")), "list: []\nnames: auto\n");
  EXPECT_EQ(error_text([] { places("names: all\n"); }),
            "test.yaml:1: names: expected a list of texts or 'auto', found 'all'");
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
