// The loader's benchmark, small: that it measures all that it must, not how fast anything is.
#include "benchmark/loader.h"

#include <gtest/gtest.h>

#include "core/file_io.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

TEST(LoaderBench, MeasuresEveryEpochAndLeavesNothingBehind) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 4, 40, 2);
  write_file_atomically(folder / "tiny.yaml", tiny_network_yaml() + "data: {crop: 8}\n");
  LoaderBench options;
  options.data = (folder / "data").string();
  options.training = options.network = (folder / "tiny.yaml").string();
  options.crop = 20;
  options.batch = 2;
  options.epochs = 3;
  const auto result = bench_loader(options);
  ASSERT_EQ(result.at("loading").size(), 3u);
  ASSERT_EQ(result.at("training").size(), 3u);
  for (size_t i = 0; i < 3; ++i) {
    for (const char* key : {"batch_ms", "batch_cpu_ms", "mb_before", "mb_after", "peak_mb"})
      EXPECT_GT(result["loading"][i].at(key).get<double>(), 0) << key;
    EXPECT_GT(result["training"][i].at("seconds").get<double>(), 0);
  }
  EXPECT_GT(result.at("step_ms").get<double>(), 0);
  const auto& pages = result.at("crop_pages");
  EXPECT_NEAR(pages.at("wanted_mb").get<double>(), 2e-6 * 20 * 20 * 2 * 20, 1e-9);
  EXPECT_GE(pages.at("touched_mb").get<double>(), pages.at("wanted_mb").get<double>());
  EXPECT_FALSE(std::filesystem::exists(folder / "data/.cache"));
  const std::string table = markdown_loader(result);
  EXPECT_NE(table.find("| 1, cache made"), std::string::npos) << table;
  EXPECT_NE(table.find("MB of its frame"), std::string::npos) << table;
}

}  // namespace
}  // namespace ld
