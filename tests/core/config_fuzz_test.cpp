// Thousands of damaged configurations: each is read or gives one clear line.
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>

#include "core/config_tree.h"
#include "core/error.h"
#include "core/file_io.h"
#include "tests/support/damage.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "training/run/config_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// All configurations of the project, and one with every key.
std::vector<std::string> good_configs() {
  std::vector<std::string> texts = {config_to_yaml(TrainConfig{})};
  for (const fs::directory_entry& entry : fs::directory_iterator(fs::path(LD_SOURCE_DIR) / "configs"))
    if (entry.path().extension() == ".yaml") texts.push_back(read_file(entry.path()));
  std::sort(texts.begin(), texts.end());  // in the same order on every file system
  return texts;
}

/// Replaces one word by what YAML may hold but a configuration should not, or puts it before a line.
std::string other_yaml(const std::string& text, RandomStream& random) {
  static const char* words[] = {
      "&a [*a, *a, *a]",
      "*a",
      "!!python/object:os.system",
      "<<: *a",
      "1e999",
      "-1",
      "99999999999999999999999999",
      "0x7fffffffffffffff",
      ".nan",
      ".inf",
      "~",
      "null",
      "yes",
      "{a: {b: {c: {d: 1}}}}",
      "[[1], [2, [3]]]",
      "? [complex]\n: key",
      "|\n  block\n  text",
      "\"quoted \\n \\x00 \\u2028 \\\"\"",
      "'single '' quote'",
      "%YAML 9.9\n---",
      "---",
      "...",
      "\t",
      "\xef\xbb\xbf",
      "\xff\xfe\x00z",
      "# comment",
      ": ",
      "- ",
      "[",
      "}",
      "\x1b[31m",
      "a\rb",
  };
  const std::string ends = " ,:[]{}\n";
  const size_t start = text.find_first_not_of(ends, below(random, text.size()));
  if (start == std::string::npos) return text;
  const size_t end = std::min(text.find_first_of(ends, start), text.size());
  std::string word = words[below(random, std::size(words))];
  switch (random.below(20)) {
    case 0:
      word = std::string(20000, random.below(2) == 0 ? '[' : '{');
      break;
    case 1:
      word = std::string(5000, 'n');
      break;
    case 2:
      for (word = "{"; word.size() < 20000;) word += "k" + std::to_string(word.size()) + ": {";
      break;
    default:
      break;
  }
  std::string changed = text;
  if (random.below(4) == 0) return changed.insert(text.rfind('\n', start) + 1, word + "\n");
  return changed.replace(start, end - start, word);
}

/// The configuration as it would be written, if it can be read; its Error must name `name`.
std::optional<std::string> read_whole(const std::function<TrainConfig()>& read, const std::string& name) {
  try {
    return config_to_yaml(read());
  } catch (const Error& error) {
    expect_clear(error.what(), name);
    return std::nullopt;
  }
}

TEST(ConfigFuzz, DamagedConfigsAreReadOrGiveOneLine) {
  const TemporaryFolder folder;
  const fs::path path = folder / "fuzz.yaml";
  for (const char* base : {"layer.yaml", "quick.yaml", "common_fast.yaml", "samples_fast.yaml"})
    fs::copy_file(fs::path(LD_SOURCE_DIR) / "configs" / base, folder / base);
  const std::vector<std::string> files = good_configs();
  int errors = 0;
  run_trials(2500, [&](uint32_t number, RandomStream& random) {
    const std::string& good = files[number / 4 % files.size()];
    std::string text = number % 4 == 0 ? damaged(good, random) : other_yaml(good, random);
    if (number % 4 > 1) text = other_yaml(text, random);
    if (number % 4 == 3) text = damaged(text, random);
    write_new_file(path, text);
    const auto written = read_whole([&] { return read_train_config(path); }, "fuzz.yaml");
    if (!written) {
      ++errors;
      return;
    }
    // What was accepted must survive being stored in the run folder.
    const auto again =
        read_whole([&] { return config_from_tree<TrainConfig>(parse_config(*written, "written")); },
                   "no error expected");
    EXPECT_EQ(again.value_or(""), *written);
  });
  EXPECT_GT(errors, 1500);
  EXPECT_LT(errors, 2500) << "some damages do no harm";
}

TEST(ConfigFuzz, DamagedOverridesAreAppliedOrGiveOneLine) {
  const std::vector<std::string> good = {"optimizer.learning_rate=0.1", "network.unet.encoder=[[1, 2], [3]]",
                                         "data.paths=[{path: a, weight: 2}]", "loss=smape"};
  int errors = 0;
  run_trials(1000, [&](uint32_t number, RandomStream& random) {
    const std::string& start = good[number % good.size()];
    const std::string text = number % 3 == 0 ? damaged(start, random) : other_yaml(start, random);
    const auto read = [&] {
      ConfigNode root = parse_config("", "empty.yaml");
      apply_override(root, text);
      return config_from_tree<TrainConfig>(root);
    };
    if (!read_whole(read, "command line")) ++errors;
  });
  EXPECT_GT(errors, 500);
  EXPECT_LT(errors, 1000);
}

TEST(ConfigFuzz, BombsAreRefusedSoon) {
  const auto start = std::chrono::steady_clock::now();
  std::string bomb = "a: &a [x, x, x, x, x, x, x, x, x]\n";
  for (char c = 'b'; c < 'k'; ++c)
    bomb += fmt::format("{0}: &{0} [*{1}, *{1}, *{1}, *{1}, *{1}, *{1}, *{1}, *{1}, *{1}]\n", c, char(c - 1));
  EXPECT_ERROR(parse_config(bomb, "bomb.yaml"), "bomb.yaml:1: found an anchor");
  for (const char* open : {"[", "{", "- ", "{a: ", "? ", "[{", "!", "&a ", "\"", "|"}) {
    std::string deep;
    while (deep.size() < 500'000) deep += open;
    EXPECT_ERROR(config_from_tree<TrainConfig>(parse_config(deep, "deep.yaml")), "deep.yaml");
  }
  EXPECT_ERROR(parse_config(std::string((1 << 20) + 1, 'a'), "long.yaml"), "long.yaml");
  std::string keys;
  for (int i = 0; keys.size() < 500'000; ++i) keys += fmt::format("k{}: 1\n", i);
  EXPECT_ERROR(config_from_tree<TrainConfig>(parse_config(keys, "keys.yaml")),
               "more than 1000 keys in one map");
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 20);
}

}  // namespace
}  // namespace ld
