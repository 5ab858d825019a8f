#include "weights/weight_file.h"

#include <gtest/gtest.h>

#include "core/file_io.h"
#include "frame/schema.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

NetworkConfig small_network() {
  NetworkConfig network;
  network.features = {"radiance", "albedo", "motion"};
  network.layers = 3;
  network.unet.encoder = {{8, 8}, {16}};
  network.unet.upsampling = "nearest";
  return network;
}

WeightsHeader header_of(const fs::path& path, const Metadata& metadata) {
  const float value = 1;
  write_safetensors(path, {{"weight", DType::f32, {1}, &value, 4}}, metadata);
  const SafetensorsFile file(path);
  return read_weights_header(file);
}

TEST(WeightFile, HeaderRoundTrip) {
  const TemporaryFolder folder;
  const Metadata metadata = make_weights_metadata(small_network(), R"({"steps": 40})");
  const WeightsHeader header = header_of(folder / "w.safetensors", metadata);
  EXPECT_EQ(header.provenance, R"({"steps": 40})");
  EXPECT_EQ(config_to_yaml(header.network), config_to_yaml(small_network()));
  EXPECT_EQ(header.network.layers, 3);
  EXPECT_EQ(header.network.features, small_network().features);
  EXPECT_EQ(metadata.at("features"), "radiance 3 tone_map\nalbedo 3 identity\nmotion 2 squash 16\n");
}

TEST(WeightFile, EveryMismatchIsNamed) {
  const TemporaryFolder folder;
  const Metadata good = make_weights_metadata(small_network(), "{}");
  const auto with = [&](const std::string& key, const std::string& value) {
    Metadata changed = good;
    changed[key] = value;
    return header_of(folder / "w.safetensors", changed);
  };
  const auto without = [&](const std::string& key) {
    Metadata changed = good;
    changed.erase(key);
    return header_of(folder / "w.safetensors", changed);
  };
  EXPECT_ERROR(without("format"), "not a weight file of this project");
  EXPECT_ERROR(with("format", "pt"), "\"format\": \"pt\"");
  for (const char* key : {"format_version", "network", "features", "schema_version", "provenance"})
    EXPECT_ERROR(without(key), std::string("no \"") + key + "\" in its metadata");
  EXPECT_ERROR(with("format_version", "2"), "\"format_version\" is 2; this program knows versions up to 1");
  EXPECT_ERROR(with("schema_version", "99"), "use a newer version");
  EXPECT_ERROR(with("format_version", "one"), "\"format_version\" is \"one\"");
  EXPECT_ERROR(with("network", "layers: 99\n"),
               "w.safetensors: metadata: network:1: layers: expected a whole number");
  EXPECT_ERROR(with("network", "layer: 2\n"), "unknown key 'layer'");
  EXPECT_ERROR(with("network", "[1"), "w.safetensors: metadata: network");
  EXPECT_ERROR(with("network", "features: [radiance, hue]\n"),
               "w.safetensors: metadata: network: unknown feature 'hue'");
  EXPECT_ERROR(with("features", "radiance 3 tone_map\nalbedo 3 squash 2\nmotion 2 squash 16\n"),
               "it says \"albedo 3 squash 2\" (name, channels, encoding, scale) where this program has "
               "\"albedo 3 identity\"");
  EXPECT_ERROR(with("features", "radiance 3 tone_map\n"), "it says \"nothing more\"");
  EXPECT_ERROR(with("features", good.at("features") + "hue 1 identity\n"), "has \"nothing more\"");
  EXPECT_ERROR(with("provenance", "{\"steps\""), "metadata: provenance: not valid JSON");
  // A wrong file is a failure while running, not a wrong command line.
  try {
    with("network", "layers: 99\n");
  } catch (const Error& error) {
    EXPECT_EQ(error.exit_code(), 1);
  }
}

TEST(WeightFile, ResolvesFilesCheckpointsAndRuns) {
  const TemporaryFolder folder;
  EXPECT_ERROR(resolve_model(folder / "none"), "no such model");
  write_file_atomically(folder / "w.safetensors", "x");
  EXPECT_EQ(resolve_model(folder / "w.safetensors"), folder / "w.safetensors");
  make_folder(folder / "run");
  EXPECT_ERROR(resolve_model(folder / "run"),
               "looked for weights.safetensors (a checkpoint), checkpoints/best");
  const fs::path checkpoints = folder / "run/checkpoints";
  write_file_atomically(checkpoints / "step_00000020/weights.safetensors", "x");
  EXPECT_EQ(resolve_model(checkpoints / "step_00000020"), checkpoints / "step_00000020/weights.safetensors");
  fs::create_directory_symlink("step_00000020", checkpoints / "last");
  EXPECT_EQ(resolve_model(folder / "run"), checkpoints / "last/weights.safetensors");
  fs::create_directory_symlink("step_00000020", checkpoints / "best");
  EXPECT_EQ(resolve_model(folder / "run"), checkpoints / "best/weights.safetensors");
}

}  // namespace
}  // namespace ld
