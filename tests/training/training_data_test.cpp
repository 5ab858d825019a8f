#include "training/training_data.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"
#include "training/trainer.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

TrainConfig config_for(const std::string& data_yaml) {
  TrainConfig config = config_from_tree<TrainConfig>(parse_config(tiny_network_yaml() + data_yaml, "tiny"));
  config.data.crop = 8;
  config.data.batch = 2;
  config.run = {4, 2, 4, 4};
  return config;
}

/// As write_tiny_dataset, without defocus and motion.
void write_sharp_dataset(const fs::path& folder, int train) {
  write_tiny_dataset(folder, train);
  for (const ManifestFrame& entry : read_manifest(folder).frames) {
    Faults faults;
    Frame frame = read_frame(frame_path(folder, entry.name), {}, faults);
    for (const char* name : {"motion", "coc", "roughness"})
      for (int s = 0; s < frame.spp; ++s)
        for (int c = 0; c < find_feature(name).channels; ++c)
          std::fill_n(frame.plane(s, find_feature(name).offset + c), frame.plane_size(), 0.0F);
    write_frame(frame_path(folder, entry.name), frame);
  }
}

TEST(DataSets, PathOrPaths) {
  DataConfig config;
  EXPECT_ERROR(data_sets(config), "data.path is empty");
  config.path = "a";
  EXPECT_EQ(data_sets(config).at(0).path, "a");
  config.paths = {{"b", 2}, {"c", 1}};
  EXPECT_ERROR(data_sets(config), "both given");
  config.path.clear();
  EXPECT_EQ(data_sets(config).at(0).weight, 2);
  config.paths.push_back({"./b", 1});
  EXPECT_ERROR(data_sets(config), "stands twice");
  config.paths.back().path.clear();
  EXPECT_ERROR(data_sets(config), "data.paths[2].path is empty");
}

TEST(DataSets, TrainsOnSeveralAndValidatesOnAll) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "a", 3, 16, 2);
  write_tiny_dataset(folder / "b", 2, 20, 1);
  const std::string one = fmt::format("data: {{paths: [{{path: {}}}]}}\n", (folder / "a").string());
  const std::string two = fmt::format("data: {{paths: [{{path: {}}}, {{path: {}, weight: 3}}]}}\n",
                                      (folder / "a").string(), (folder / "b").string());
  EXPECT_EQ(make_validation_stores(config_for(one)).size(), 1u);
  EXPECT_EQ(make_validation_stores(config_for(two)).size(), 2u);
  Trainer trainer(config_for(two), folder / "run");
  trainer.train();
  EXPECT_EQ(trainer.state().step, 4);
  EXPECT_EQ(trainer.total_steps(), 1000 * 2);  // five frames, two a batch
  EXPECT_NE(trainer.state().dataset.find('+'), std::string::npos);
  EXPECT_NE(read_file(folder / "run/config.yaml").find("weight: 3"), std::string::npos);
}

TEST(AutoFeatures, AreFoundKeptAndContinuedWith) {
  const TemporaryFolder folder;
  write_sharp_dataset(folder / "data", 3);
  TrainConfig config = config_for(fmt::format("data: {{path: {}}}\n", (folder / "data").string()));
  config.network.features = {kAutoFeatures};
  const std::vector<std::string> expected = {"radiance", "normal", "depth", "albedo", "specular"};
  {
    Trainer trainer(config, folder / "run");
    trainer.train();
    EXPECT_EQ(trainer.network().config().features, expected);
  }
  EXPECT_NE(
      read_file(folder / "run/config.yaml").find("features: [radiance, normal, depth, albedo, specular]"),
      std::string::npos);
  const SafetensorsFile weights(resolve_model(folder / "run"));
  EXPECT_EQ(read_weights_header(weights).network.features, expected);

  // A run continues with what it found, whatever its data became.
  write_tiny_dataset(folder / "data", 3);
  config.run.max_steps = 6;
  Trainer again(config, folder / "run");
  again.train();
  EXPECT_EQ(again.state().step, 6);
  EXPECT_EQ(again.network().config().features, expected);
  Trainer fresh(config, folder / "fresh");
  EXPECT_EQ(fresh.network().config().features, mh20_feature_names());
}

}  // namespace
}  // namespace ld
