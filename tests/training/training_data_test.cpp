#include "training/training_data.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/file_io.h"
#include "models/initialise.h"
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

TEST(Samples, ARangeIsTwoNumbersInOrder) {
  DataConfig config;
  EXPECT_TRUE(sample_range(config).all());
  EXPECT_EQ(validation_samples(config).input, 0);
  config.samples = {2, 8};
  EXPECT_EQ(sample_range(config).least, 2);
  EXPECT_EQ(sample_range(config).most, 8);
  EXPECT_EQ(validation_samples(config).input, 8);
  config.validation_samples = 4;
  EXPECT_EQ(validation_samples(config).input, 4);
  config.samples = {8, 2};
  EXPECT_ERROR(sample_range(config), "data.samples: [8, 2]; expected [LEAST, MOST]");
  config.samples = {8};
  EXPECT_ERROR(sample_range(config), "data.samples: [8]");
  EXPECT_ERROR(config_for("data: {samples: [0, 4]}\n"), "samples");
}

TEST(Samples, AFrameWithTooFewIsNamedBeforeTheFirstStep) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 3, 16, 4);
  TrainConfig config = config_for(fmt::format("data: {{path: {}}}\n", (folder / "data").string()));
  config.data.samples = {5, 8};
  EXPECT_ERROR(Trainer(config, folder / "run"), "data.samples: frame frame_0 has 4 samples a pixel");
  config.data.samples = {1, 4};
  config.data.validation_samples = 5;
  EXPECT_ERROR(Trainer(config, folder / "run"),
               "data.validation_samples: the validation frame frame_3 has 4 samples a pixel, fewer than 5");
}

TEST(Samples, ValidationTakesTheFirstOnesOfEachFrame) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 3, 16, 4);
  const auto config_of = [&](const std::string& data) {
    return config_for(fmt::format("data: {{path: {}}}\n", (folder / data).string()));
  };
  TrainConfig config = config_of("data");
  const std::shared_ptr<Network> network = make_network(config.network);
  initialise(*network, 1);
  ProcessGroup alone{ProcessGroupOptions{}};
  const auto scores = [&](const TrainConfig& of) {
    const Validation validation(make_validation_stores(of), 1, validation_samples(of.data));
    return validation.run(*network, make_loss("smape"), alone, [] { return false; })->scores;
  };
  const auto all = scores(config);
  config.data.samples = {1, 2};
  const auto first = scores(config);
  EXPECT_EQ(scores(config), first);
  EXPECT_NE(first, all);
  config.data.validation_samples = 4;
  EXPECT_EQ(scores(config), all);

  // The same frames with those samples alone.
  fs::copy(folder / "data", folder / "few", fs::copy_options::recursive);
  fs::remove_all(folder / "few/.cache");
  for (const ManifestFrame& entry : read_manifest(folder / "few").frames) {
    Faults faults;
    const fs::path path = frame_path(folder / "few", entry.name);
    const Frame frame = read_frame(path, {}, faults, 2);
    ASSERT_EQ(frame.spp, 2);
    write_frame(path, frame);
  }
  EXPECT_EQ(scores(config_of("few")), first);
}

TEST(Samples, ATrainingDrawsThemAndIsRepeatable) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder / "data", 4, 16, 6);
  TrainConfig config = config_for(fmt::format("data: {{path: {}}}\n", (folder / "data").string()));
  const auto weights = [&](const std::string& run) {
    Trainer trainer(config, folder / run);
    trainer.train();
    return read_file(resolve_model(folder / run));
  };
  const std::string all = weights("all");
  config.data.samples = {6, 6};
  EXPECT_EQ(weights("each"), all) << "all six, whether drawn or not";
  config.data.samples = {1, 4};
  const std::string drawn = weights("drawn");
  EXPECT_NE(drawn, all);
  EXPECT_EQ(weights("again"), drawn);
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
  // What docs/data_format.md promises of the best checkpoint's weights.
  const auto provenance = nlohmann::json::parse(read_weights_header(weights).provenance);
  EXPECT_EQ(provenance.at("seed"), config.seed);
  EXPECT_EQ(provenance.at("loss"), config.loss);
  EXPECT_EQ(provenance.at("dataset"), data_checksum(config.data));
  EXPECT_GT(provenance.at("steps"), 0);
  EXPECT_GT(provenance.at("validation_loss"), 0);
  EXPECT_EQ(provenance.at("program"), "ld_train " LD_VERSION);

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
