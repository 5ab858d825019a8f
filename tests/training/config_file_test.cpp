// Configurations that build on others.
#include "training/run/config_file.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

class ConfigBase : public ::testing::Test {
 protected:
  void write(const std::string& name, const std::string& text) const {
    write_file_atomically(folder_ / name, text);
  }
  TrainConfig read(const std::string& name, const std::vector<std::string>& overrides = {}) const {
    return read_train_config(folder_ / name, overrides);
  }
  /// What is wrong with a file, without the folder's name; a mistake in a configuration has exit code 2.
  std::string complaint(const std::string& name, const std::vector<std::string>& overrides = {}) const {
    try {
      read(name, overrides);
    } catch (const UsageError& error) {
      std::string text = error.what();
      const std::string folder = folder_.path().string() + "/";
      for (size_t at = 0; (at = text.find(folder)) != std::string::npos;) text.erase(at, folder.size());
      return text;
    }
    return "no complaint";
  }

  TemporaryFolder folder_;
};

TEST_F(ConfigBase, MapsMergeListsReplaceAndTheCommandLineComesLast) {
  write("base.yaml",
        "seed: 7\nepochs: 3\nnetwork: {layers: 3, sample_reducer: [8, 8, 8], unet: {context: 5, bottleneck: "
        "[6]}}\n"
        "optimizer: {learning_rate: 0.1, one_cycle: {rise: 0.5}}\n");
  write("own.yaml",
        "base: base.yaml\nepochs: 4\nnetwork: {sample_reducer: [4], unet: {context: 9}}\n"
        "optimizer: {one_cycle: {end: 0.25}}\nwatch: {enabled: false}\n");
  const TrainConfig config = read("own.yaml", {"seed=9", "optimizer.one_cycle.rise=0.75"});
  EXPECT_EQ(config.seed, 9U);
  EXPECT_EQ(config.epochs, 4);
  EXPECT_EQ(config.network.layers, 3);
  EXPECT_EQ(config.network.sample_reducer, std::vector<int64_t>{4});
  EXPECT_EQ(config.network.unet.context, 9);
  EXPECT_EQ(config.network.unet.bottleneck, std::vector<int64_t>{6});
  EXPECT_EQ(config.optimizer.learning_rate, 0.1);
  EXPECT_EQ(config.optimizer.one_cycle.rise, 0.75);
  EXPECT_EQ(config.optimizer.one_cycle.end, 0.25);
  EXPECT_FALSE(config.watch.enabled);
}

TEST_F(ConfigBase, IsFoundFromTheFolderOfTheFileThatNamesIt) {
  fs::create_directories(folder_ / "deep/er");
  write("top.yaml", "epochs: 3\nseed: 5\n");
  write("deep/middle.yaml", "base: ../top.yaml\nseed: 6\n");
  write("deep/er/own.yaml", "base: ../middle.yaml\nloss: l1\n");
  const TrainConfig config = read("deep/er/own.yaml");
  EXPECT_EQ(config.epochs, 3);
  EXPECT_EQ(config.seed, 6U);
  EXPECT_EQ(config.loss, "l1");
  write("deep/absolute.yaml", "base: " + (folder_ / "top.yaml").string() + "\n");
  EXPECT_EQ(read("deep/absolute.yaml").epochs, 3);
}

TEST_F(ConfigBase, ANetworkOfAnotherNameTakesNothingOver) {
  write("layers.yaml", "epochs: 3\nnetwork: {layers: 3, rejection: true, kernel_size: 5}\n");  // name: layer
  write("splat.yaml", "base: layers.yaml\nnetwork: {name: pixel_splat, sample_reducer: [4]}\n");
  NetworkConfig expected;
  expected.name = "pixel_splat";
  expected.sample_reducer = {4};
  EXPECT_EQ(config_to_yaml(read("splat.yaml").network), config_to_yaml(expected));
  EXPECT_EQ(read("splat.yaml").epochs, 3);
  // The name alone decides, whether or not the base writes out the default one, or has it from its own base.
  write("same.yaml", "base: layers.yaml\nnetwork: {name: layer}\n");
  EXPECT_EQ(read("same.yaml").network.layers, 3);
  write("smaller.yaml", "base: splat.yaml\nnetwork: {kernel_size: 7}\n");
  write("named.yaml", "base: smaller.yaml\nnetwork: {name: pixel_splat, rejection: true}\n");
  const NetworkConfig named = read("named.yaml").network;
  EXPECT_EQ(named.sample_reducer, std::vector<int64_t>{4});
  EXPECT_EQ(named.kernel_size, 7);
  EXPECT_TRUE(named.rejection);
  // On the command line, a name is a value as all others are.
  EXPECT_EQ(read("layers.yaml", {"network.name=pixel_splat"}).network.kernel_size, 5);
}

TEST_F(ConfigBase, TheResolvedConfigurationReadsBackWithoutAnyBase) {
  write("base.yaml", "epochs: 3\nnetwork: {kernel_size: 5}\n");
  write("own.yaml", "base: base.yaml\nseed: 4\n");
  const std::string resolved = config_to_yaml(read("own.yaml"));
  EXPECT_EQ(resolved.find("base"), std::string::npos);
  write("resolved.yaml", resolved);
  fs::remove(folder_ / "base.yaml");
  EXPECT_EQ(config_to_yaml(read("resolved.yaml")), resolved);
}

TEST_F(ConfigBase, MistakesNameFileAndLine) {
  write("own.yaml", "seed: 1\nbase: none.yaml\n");
  EXPECT_EQ(complaint("own.yaml"),
            "own.yaml:2: base: expected a configuration, by its path from the folder of this file; found no "
            "file none.yaml");
  write("folder.yaml", "base: .\n");
  EXPECT_NE(complaint("folder.yaml").find("folder.yaml:1: base: expected a configuration"),
            std::string::npos);
  write("empty.yaml", "base:\n");
  EXPECT_NE(complaint("empty.yaml").find("empty.yaml:1: base: expected a configuration"), std::string::npos);
  write("list.yaml", "base: [own.yaml]\n");
  EXPECT_EQ(complaint("list.yaml"), "list.yaml:1: base: expected a text, found a list");
  // In the base, the mistake is the base's.
  write("wrong.yaml", "epochs: 3\nnetwork:\n  kernel_sise: 5\n");
  write("on_wrong.yaml", "base: wrong.yaml\nnetwork: {layers: 3}\n");
  EXPECT_NE(complaint("on_wrong.yaml").find("wrong.yaml:3: unknown key 'network.kernel_sise'"),
            std::string::npos)
      << complaint("on_wrong.yaml");
  write("right.yaml", "epochs: 3\nnetwork: {layers: 3}\n");
  write("on_right.yaml", "base: right.yaml\nnetwork:\n  layers: many\n");
  EXPECT_NE(complaint("on_right.yaml").find("on_right.yaml:3: network.layers: expected a whole number"),
            std::string::npos)
      << complaint("on_right.yaml");
  write("flat.yaml", "base: right.yaml\nnetwork: none\n");
  EXPECT_NE(complaint("flat.yaml").find("flat.yaml:2: network: expected a map"), std::string::npos);
  write("broken.yaml", "epochs: [1\n");
  write("on_broken.yaml", "base: broken.yaml\n");
  EXPECT_NE(complaint("on_broken.yaml").find("broken.yaml:"), std::string::npos);
  write("inner.yaml", "network: {base: right.yaml}\n");
  EXPECT_NE(complaint("inner.yaml").find("unknown key 'network.base'"), std::string::npos);
  EXPECT_NE(
      complaint("right.yaml", {"base=own.yaml"}).find("command line: base: expected this key in a file"),
      std::string::npos);
  EXPECT_ERROR(read("nowhere.yaml"), "nowhere.yaml");
}

TEST_F(ConfigBase, ACircleIsAnErrorThatShowsIt) {
  write("self.yaml", "base: ./self.yaml\n");
  EXPECT_EQ(
      complaint("self.yaml"),
      "self.yaml:1: base: expected bases of which the last has none, found a circle: self.yaml -> self.yaml");
  write("a.yaml", "epochs: 2\nbase: b.yaml\n");
  write("b.yaml", "base: c.yaml\n");
  write("c.yaml", "\nbase: link.yaml\n");
  fs::create_symlink("a.yaml", folder_ / "link.yaml");
  EXPECT_EQ(complaint("a.yaml"),
            "c.yaml:2: base: expected bases of which the last has none, found a circle: a.yaml -> b.yaml -> "
            "c.yaml -> link.yaml");
}

}  // namespace
}  // namespace ld
