// What `ld_inspect --keys` lists comes from the same description as what the reader takes.
#include "core/config_keys.h"

#include <gtest/gtest.h>

#include <fmt/format.h>

namespace ld {
namespace {

struct Lamp {
  double power = 0.5;

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("power", power, at_least(0));
  }
};

struct House {
  bool open = true;
  uint64_t seed = 3;
  int64_t floors = 2;
  std::string colour = "red";
  std::vector<std::string> rooms = {"hall", "*"};
  std::vector<std::vector<int64_t>> plan = {{1, 2}, {3}};
  Lamp lamp;
  std::vector<Lamp> lamps;

  template <class Visitor>
  void visit(Visitor& v) {
    v.field("open", open);
    v.field("seed", seed);
    v.field("floors", floors, Range{1, 90});
    v.field("colour", colour, {"red", "white"});
    v.field_or_word("rooms", rooms, "auto");
    v.field("plan", plan, Range{1, 4096});
    v.section("lamp", lamp);
    v.sections("lamps", lamps);
    v.field("loft", open);
  }
};

TEST(ConfigKeys, SayTypeDefaultAndWhatIsAllowed) {
  const std::vector<std::string> expected = {
      "open|true or false|true|",
      "seed|whole number|3|at least 0",
      "floors|whole number|2|1 to 90",
      "colour|text|red|red, white",
      "rooms|list of texts, or auto|[hall, \"*\"]|",
      "plan|list of lists of whole numbers|[[1, 2], [3]]|1 to 4096",
      "lamp.power|number|0.5|at least 0",
      "lamps|list of maps|[]|",
      "lamps[].power|number|0.5|at least 0",
      "loft|true or false|true|",
  };
  std::vector<std::string> found;
  for (const ConfigKey& key : config_keys<House>())
    found.push_back(fmt::format("{}|{}|{}|{}", key.key, key.type, key.value, key.allowed));
  EXPECT_EQ(found, expected);
}

TEST(ConfigKeys, DefaultsAreReadBack) {
  std::string text;
  for (const ConfigKey& key : config_keys<House>())
    if (key.key.find('.') == std::string::npos) text += key.key + ": " + key.value + "\n";
  const auto house = config_from_tree<House>(parse_config(text, "defaults"));
  EXPECT_EQ(config_to_yaml(house), config_to_yaml(House()));
}

}  // namespace
}  // namespace ld
