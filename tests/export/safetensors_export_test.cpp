#include "export/safetensors_export.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/file_io.h"
#include "export/model_card.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "weights/checkpoint_files.h"
#include "weights/model_file.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

class SafetensorsExport : public ::testing::Test {
 protected:
  SafetensorsExport() : source_{small_network(small_config(), torch::kFloat32), R"({"steps": 3})"} {
    inputs_ = parity_inputs(small_config(), {});
  }
  Parity exported(DType type) { return export_safetensors(source_, path(), type, inputs_); }
  std::filesystem::path path() const { return folder_ / "w.safetensors"; }

  TemporaryFolder folder_;
  ExportSource source_;
  std::vector<NetworkInput> inputs_;
};

TEST_F(SafetensorsExport, Float32KeepsEveryBit) {
  EXPECT_EQ(exported(DType::f32).largest_relative_difference, 0);
  const ExportSource read = load_source(path());
  EXPECT_EQ(read.provenance, R"({"steps": 3})");
  const auto expected = source_.network->named_parameters();
  for (const auto& parameter : read.network->named_parameters())
    EXPECT_TRUE(parameter.value().equal(expected[parameter.key()])) << parameter.key();
}

TEST_F(SafetensorsExport, Float16StaysWithinItsBoundAndTheFileSaysByHowMuch) {
  const Parity parity = exported(DType::f16);
  EXPECT_GT(parity.largest_relative_difference, 0);
  EXPECT_LE(parity.largest_relative_difference, kHalfTolerance);
  const auto said = nlohmann::json::parse(SafetensorsFile(path()).metadata_value("export"));
  EXPECT_EQ(said.at("dtype"), "f16");
  EXPECT_EQ(said.at("rounded_weights").at("largest_relative_difference"), parity.largest_relative_difference);
  EXPECT_EQ(said.at("rounded_weights").at("allowed"), kHalfTolerance);
  EXPECT_EQ(largest_relative_difference(outputs(*load_network(path()), inputs_),
                                        outputs(*source_.network, inputs_)),
            parity.largest_relative_difference);
}

TEST_F(SafetensorsExport, WeightsBeyondHalfsRangeAreNamed) {
  const torch::NoGradGuard no_graph;
  source_.network->named_parameters()["unet.context.weight"].view(-1)[3] = 7e4F;
  EXPECT_ERROR(exported(DType::f16), "'unet.context.weight' reaches 70000");
  EXPECT_FALSE(exists(path()));
  EXPECT_EQ(exported(DType::f32).largest_relative_difference, 0);
}

TEST_F(SafetensorsExport, MissingModelsAreErrorsAndLeaveNothing) {
  EXPECT_ERROR(load_source(folder_ / "none"), "no such model");
  EXPECT_ERROR(untrained_source(folder_ / "none.yaml", 1), "none.yaml");
  write_file_atomically(folder_ / "c.yaml", "loss: smape\n");
  EXPECT_ERROR(untrained_source(folder_ / "c.yaml", 1), "no section 'network'");
  write_file_atomically(folder_ / "base.yaml", "network: {features: auto}\n");
  write_file_atomically(folder_ / "c.yaml", "base: base.yaml\n");
  EXPECT_ERROR(untrained_source(folder_ / "c.yaml", 1), "name the features");
  write_file_atomically(folder_ / "c.yaml", "network: {features: auto}\n");
  EXPECT_ERROR(untrained_source(folder_ / "c.yaml", 1), "name the features");
}

TEST_F(SafetensorsExport, AFlippedBitInACheckpointIsNamed) {
  const std::filesystem::path checkpoint = folder_ / "run/checkpoints/step_1";
  make_folder(checkpoint);
  save_network(checkpoint / "weights.safetensors", *source_.network, "", DType::f32);
  for (const char* other : {"optimizer.safetensors", "state.json"})
    write_file_atomically(checkpoint / other, "x");
  write_checkpoint_checksums(checkpoint);
  EXPECT_NO_THROW(load_source(checkpoint));
  std::string bytes = read_file(checkpoint / "weights.safetensors");
  bytes[bytes.size() - 3] ^= 1;
  write_file_atomically(checkpoint / "weights.safetensors", bytes);
  EXPECT_ERROR(load_source(checkpoint), "weights.safetensors: checksum ");
}

TEST(ModelCard, HoldsWhatTheFileHolds) {
  const ExportSource source = {small_network(small_config(), torch::kFloat32), R"({"steps": 3})"};
  Parity half;
  half.largest_relative_difference = 0.002;
  const std::string card =
      model_card("denoiser.safetensors", export_metadata(source, DType::f16, half, nullptr, 3));
  EXPECT_EQ(card.rfind("# denoiser.safetensors\n", 0), 0U);
  for (const char* part : {"- radiance 3 tone_map\n", "| steps | 3 |", "| dtype | f16 |", "\\|a - b\\|",
                           "| rounded_weights.largest_relative_difference | 0.002 |", "name: layer"})
    EXPECT_NE(card.find(part), std::string::npos) << part << " in\n" << card;
  EXPECT_ERROR(model_card("x", {}), "'features'");
}

TEST(ParameterCount, AHeaderThatAsksForTerabytesIsRefusedFirst) {
  const TemporaryFolder folder;
  NetworkConfig config = small_config();
  config.unet.encoder.assign(8, std::vector<int64_t>(100, 4096));
  config.unet.decoder.assign(8, std::vector<int64_t>(100, 4096));
  const float value = 1;
  const auto write = [&](const NetworkConfig& network) {
    write_safetensors(folder / "w.safetensors", {{"weight", DType::f32, {1}, &value, 4}},
                      make_weights_metadata(network, ""));
    return folder / "w.safetensors";
  };
  EXPECT_ERROR(load_network(write(config)), "w.safetensors: holds 1 numbers, but the network");
  config.unet.decoder.pop_back();
  EXPECT_ERROR(load_network(write(config)),
               "w.safetensors: metadata: network: network.unet.encoder has 8 blocks");
}

}  // namespace
}  // namespace ld
