#include "apps/inspect/inspect.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/checksum.h"
#include "core/json_text.h"
#include "tests/apps/inspect/problems.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"
#include "tests/support/tiny_dataset.h"
#include "weights/checkpoint_files.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// A wall that faces the camera under noisy light: random guides would be faults.
Frame wall(int width, int height, int spp, uint32_t seed) {
  Frame frame = random_frame(width, height, spp, seed);
  for (int s = 0; s < spp; ++s)
    for (int c = kNormalOffset; c < channel_count(frame.features); ++c)
      std::fill_n(frame.plane(s, c), frame.plane_size(), c < kDepthOffset - 1 ? 0.0F : 1.0F);
  for (int s = 0; s < spp; ++s) std::fill_n(frame.plane(s, kDepthOffset), frame.plane_size(), 2.0F);
  frame.info.depth_scale = 2;
  return frame;
}

/// `train` + 1 validation + 1 test frames of walls.
void write_walls(const fs::path& folder, int train, int size, int spp) {
  Manifest manifest;
  for (int i = 0; i < train + 2; ++i) {
    const std::string name = "frame_" + std::to_string(i);
    write_frame(frame_path(folder, name), wall(size, size, spp, static_cast<uint32_t>(i)));
    Image reference(size, size, 3);
    std::fill(reference.pixels.begin(), reference.pixels.end(), 0.5F + 0.01F * static_cast<float>(i));
    write_image(reference_path(folder, name), reference);
    ManifestFrame& entry = manifest.frames.emplace_back();
    entry.name = name;
    entry.split = i < train ? "train" : (i == train ? "validation" : "test");
  }
  add_to_manifest(folder, manifest);
}

void write_weights(const fs::path& path, float value = 0.5F) {
  const std::vector<float> values(12, value);
  write_safetensors(path, {{"reducer.weight", DType::f32, {3, 4}, values.data(), 48}},
                    make_weights_metadata(NetworkConfig(), R"({"dataset": "tiny", "steps": 40})"));
}

void write_checkpoint(const fs::path& folder) {
  write_weights(folder / "weights.safetensors");
  const double moment = 0.1;
  write_safetensors(folder / "optimizer.safetensors", {{"moment", DType::f64, {1}, &moment, 8}}, {});
  write_file_atomically(folder / "state.json", R"({"step": 40, "best_step": 20})");
  write_checkpoint_checksums(folder);
}

TEST(Inspect, AFrame) {
  const TemporaryFolder folder;
  Frame frame = wall(4, 3, 2, 0);
  for (int s = 0; s < 2; ++s)
    for (size_t p = 0; p < 12; ++p) frame.plane(s, 1)[p] = 0.25F;
  frame.info.scene = "indoor";
  write_frame(folder / "frame.exr", frame);
  const Report report = inspect(folder / "frame.exr", {});
  EXPECT_EQ(report.kind, "frame");
  EXPECT_EQ(report.facts["width"], 4);
  EXPECT_EQ(report.facts["height"], 3);
  EXPECT_EQ(report.facts["spp"], 2);
  EXPECT_EQ(report.facts["features"].size(), mh20_feature_names().size());
  EXPECT_NEAR(report.facts["mean_radiance"][1].get<double>(), 0.25, 1e-6);
  EXPECT_EQ(report.facts["scene"], "indoor");
  EXPECT_FLOAT_EQ(report.facts["depth_scale"].get<float>(), frame.info.depth_scale);
  EXPECT_TRUE(report.warnings.empty());
  EXPECT_TRUE(report.problems.empty());
  EXPECT_NE(report_text(report).find("nothing is wrong with it"), std::string::npos);
}

TEST(Inspect, FaultsOfAFrame) {
  const TemporaryFolder folder;
  Frame frame = wall(4, 1, 1, 0);
  frame.plane(0, 0)[0] = std::numeric_limits<float>::quiet_NaN();
  frame.plane(0, 1)[1] = -1;
  frame.plane(0, 2)[2] = 1e6F;
  write_frame(folder / "frame.exr", frame);
  const Report report = inspect(folder / "frame.exr", {});
  EXPECT_EQ(report.facts["masked_samples"], 1);
  EXPECT_EQ(report.facts["negative_channels"], 1);
  EXPECT_EQ(report.facts["clamped_channels"], 1);
  // One of four samples each: too many to be let pass.
  EXPECT_EQ(report.problems.size(), 3u) << report_text(report);
  EXPECT_EQ(report.facts["reference"], "none beside it");
  std::fill(frame.valid.begin(), frame.valid.end(), uint8_t{0});
  write_frame(folder / "frame.exr", frame);
  expect_problem(folder / "frame.exr", "every sample is masked out");
}

TEST(Inspect, AnImageAndDamagedFiles) {
  const TemporaryFolder folder;
  Image image(2, 2, 3);
  image.pixels = {1, 1, 1, 1, 0, 0, 0, 4, -1, 0, 0, 0};
  write_image(folder / "image.exr", image);
  const Report report = inspect(folder / "image.exr", {});
  EXPECT_EQ(report.kind, "image");
  EXPECT_EQ(report.facts["mean"], nlohmann::ordered_json({1.0, 1.0, 0.0}));
  EXPECT_EQ(report.facts["bad_channels"], 1);
  write_file_atomically(folder / "cut.exr", read_file(folder / "image.exr").substr(0, 300));
  expect_problem(folder / "cut.exr", "cut short");
  write_file_atomically(folder / "letter.txt", "Dear reader");
  expect_problem(folder / "letter.txt", "unknown extension '.txt'");
  expect_problem(folder.path(), "not a data set");
  EXPECT_ERROR(inspect(folder / "none", {}), "no such path");
}

TEST(Inspect, ADataSet) {
  const TemporaryFolder folder;
  const fs::path data = folder / "data";
  write_walls(data, 3, 8, 2);
  for (const fs::path& path : {data, data / "manifest.json"}) {
    const Report report = inspect(path, {});
    EXPECT_EQ(report.kind, "data set");
    EXPECT_EQ(report.facts["frames"], 5);
    EXPECT_EQ(report.facts["splits"]["train"], 3);
    EXPECT_EQ(report.facts["sizes"]["8 x 8, 2 samples a pixel"], 5);
    EXPECT_EQ(report.facts["features"].size(), mh20_feature_names().size());
    EXPECT_TRUE(report.problems.empty());
  }
  fs::remove(frame_path(data, "frame_0"));
  write_image(reference_path(data, "frame_1"), Image(9, 8, 3));
  write_image(frame_path(data, "frame_2"), Image(8, 8, 3));
  expect_problem(data, "frame_0.exr: listed in the manifest");
  expect_problem(data, "frame_1.reference.exr: 9 x 8 pixels, but its frame has 8 x 8");
  expect_problem(data, "frame_2.exr: no samples");
  EXPECT_EQ(inspect(data, {}).problems.size(), 3u);
  write_file_atomically(data / "manifest.json", "{}");
  expect_problem(data, "no \"format\"");
}

TEST(Inspect, VerifiesChecksumsWhenAsked) {
  const TemporaryFolder folder;
  const fs::path data = folder / "data";
  write_walls(data, 0, 8, 1);
  Manifest manifest = read_manifest(data);
  manifest.frames[0].checksum = "0123456789abcdef";
  add_to_manifest(data, manifest);
  EXPECT_EQ(problems(data), "");
  expect_problem(data, "frame_0.exr: checksum", true);
  manifest.frames[0].checksum = file_checksum(frame_path(data, "frame_0"));
  add_to_manifest(data, manifest);
  EXPECT_EQ(problems(data, true), "");
}

TEST(Inspect, Weights) {
  const TemporaryFolder folder;
  write_weights(folder / "w.safetensors");
  const Report report = inspect(folder / "w.safetensors", {});
  EXPECT_EQ(report.kind, "weights");
  EXPECT_EQ(report.facts["network"], "layer");
  EXPECT_EQ(report.facts["parameters"], 12);
  EXPECT_EQ(report.facts["provenance"]["steps"], 40);
  EXPECT_TRUE(report.problems.empty());
  write_weights(folder / "w.safetensors", std::numeric_limits<float>::infinity());
  expect_problem(folder / "w.safetensors", "12 of 12 numbers are NaN or infinite");
  const std::string bytes = read_file(folder / "w.safetensors");
  write_file_atomically(folder / "w.safetensors", bytes.substr(0, bytes.size() - 1));
  expect_problem(folder / "w.safetensors", "damaged or cut short");
  write_safetensors(folder / "other.safetensors", {}, {{"format", "pt"}});
  const Report other = inspect(folder / "other.safetensors", {});
  EXPECT_EQ(other.kind, "safetensors file");
  EXPECT_EQ(other.warnings.size(), 1u);
}

TEST(Inspect, HalfWeightsBeyondTheirRange) {
  const TemporaryFolder folder;
  const uint16_t halves[] = {0x7c00, 0x7e00, 0x7bff, 0xfbff};  // infinity, NaN, 65504, -65504
  write_safetensors(folder / "w.safetensors", {{"w", DType::f16, {4}, halves, 8}},
                    make_weights_metadata(NetworkConfig(), ""));
  expect_problem(folder / "w.safetensors", "2 of 4 numbers");
}

TEST(Inspect, ACheckpointAndARun) {
  const TemporaryFolder folder;
  const fs::path run = folder / "run", checkpoint = run / "checkpoints/step_00000040";
  write_checkpoint(checkpoint);
  Report report = inspect(checkpoint, {});
  EXPECT_EQ(report.kind, "checkpoint");
  EXPECT_EQ(report.facts["state"]["step"], 40);
  EXPECT_EQ(report.facts["weights"]["parameters"], 12);
  EXPECT_EQ(report.facts["optimizer"]["tensors"], 1);
  EXPECT_TRUE(report.problems.empty()) << report_text(report);

  write_file_atomically(run / "config.yaml", tiny_network_yaml() + "epochs: 7\n");
  write_file_atomically(run / "metrics.csv", "step,loss\n20,0.5\n40,0.25\n");
  fs::create_directory_symlink("step_00000040", run / "checkpoints/last");
  report = inspect(run, {});
  EXPECT_EQ(report.kind, "run");
  EXPECT_EQ(report.facts["config"]["epochs"], 7);
  EXPECT_EQ(report.facts["last"]["folder"], "step_00000040");
  EXPECT_EQ(report.facts["last"]["state"]["step"], 40);
  EXPECT_EQ(report.facts["last_metrics"], "40,0.25");
  EXPECT_TRUE(report.problems.empty()) << report_text(report);

  fs::create_directory_symlink("step_00000020", run / "checkpoints/best");
  expect_problem(run, "points at step_00000020, which is not there");
  write_file_atomically(checkpoint / "state.json", "{}");
  expect_problem(run, "last/state.json: checksum");
  fs::remove(checkpoint / "optimizer.safetensors");
  expect_problem(checkpoint, "optimizer.safetensors");
  fs::remove(checkpoint / "checksums.json");
  expect_problem(checkpoint, "no such file");
}

TEST(Inspect, Configs) {
  const TemporaryFolder folder;
  const fs::path path = folder / "config.yaml";
  write_file_atomically(path, tiny_network_yaml() + "loss: relmse\n");
  const Report report = inspect(path, {});
  EXPECT_EQ(report.kind, "training config");
  EXPECT_EQ(report.facts["loss"], "relmse");
  EXPECT_TRUE(report.problems.empty());
  write_file_atomically(path, "epochs: 3\nnetwrk: {layers: 2}\n");
  expect_problem(path, "config.yaml:2: unknown key 'netwrk'; did you mean 'network'?");
  write_file_atomically(path, "network: {features: [radiance, hue]}\n");
  expect_problem(path, "unknown feature 'hue'");
  write_file_atomically(path, "epochs: 3\nloss: foo\n");
  expect_problem(path, "config.yaml:2: loss: expected one of l1, l2_tonemapped");
  write_file_atomically(path, "network: {kernel_size: 8}\n");
  expect_problem(path, "network.kernel_size is 8, expected an odd number");
  write_file_atomically(path, "network: {features: auto, name: pixel_splat, layers: 3}\n");
  expect_problem(path, "network 'pixel_splat' has no layers");
  write_file_atomically(path, "network: {features: auto, demodulation: albedo, optional: [depth]}\n");
  EXPECT_TRUE(inspect(path, {}).problems.empty()) << report_text(inspect(path, {}));
  write_file_atomically(folder / "base.yaml", "loss: l1\nepochs: 7\n");
  write_file_atomically(path, "base: base.yaml\nnetwork: {features: [radiance]}\n");
  EXPECT_EQ(inspect(path, {}).facts["epochs"], 7);
  write_file_atomically(path, "base: none.yaml\n");
  expect_problem(path, "config.yaml:1: base: expected a configuration");
  write_file_atomically(path, "epochs: [1\n");
  expect_problem(path, "not valid YAML");
  write_file_atomically(path, "colour: blue\n");
  expect_problem(path, "neither a training config");
}

TEST(Inspect, Recipes) {
  const TemporaryFolder folder;
  const fs::path path = folder / "recipe.yaml";
  write_file_atomically(path,
                        "resolution: [10, 10]\nspp: 2\nframes: {train: 3, validation: 0, test: 1}\n"
                        "reference_spp: {train: 4, validation: 4, test: 8}\n");
  const Report report = inspect(path, {});
  EXPECT_EQ(report.kind, "scene recipe");
  EXPECT_EQ(report.facts["frames"]["train"], 3);
  EXPECT_EQ(report.facts["camera_paths"], 100 * (3 * 6 + 10));
  EXPECT_TRUE(report.problems.empty());
  write_file_atomically(path, "spp: 0\n");
  expect_problem(path, "recipe.yaml:1: spp: expected");
  write_file_atomically(path, "spp: 8\nreference_sp: 3\n");
  expect_problem(path, "did you mean 'reference_spp'?");
}

TEST(Inspect, TheProgramPrintsWritesJsonAndExitsByWhatItFound) {
  const TemporaryFolder folder;
  write_walls(folder / "data", 0, 8, 1);
  const std::string data = (folder / "data").string(), json = (folder / "report.json").string();
  ProgramResult result = run_program("ld_inspect", {data, "--verify", "--json", json});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("data set"), std::string::npos);
  EXPECT_NE(result.output.find("validation: 1"), std::string::npos);
  nlohmann::json report = parse_json(read_file(json), json);
  EXPECT_EQ(report["kind"], "data set");
  EXPECT_EQ(report["facts"]["frames"], 2);
  EXPECT_EQ(report["problems"].size(), 0u);

  EXPECT_EQ(report["facts"]["examined_frames"], 2);
  EXPECT_EQ(report["findings"].size(), 1u);
  EXPECT_EQ(report["findings"][0]["check"], "features");
  EXPECT_EQ(report["findings"][0]["severity"], "warning");
  result = run_program("ld_inspect", {data, "--frames", "1", "--json", json});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(parse_json(read_file(json), json)["facts"]["examined_frames"], 1);
  expect_failure(run_program("ld_inspect", {data, "--frames", "0"}), 2, {"--frames"});

  fs::remove(frame_path(folder / "data", "frame_0"));
  expect_failure(run_program("ld_inspect", {data, "--json", json}), 1, {"1 problem found"});
  report = parse_json(read_file(json), json);
  EXPECT_EQ(report["problems"].size(), 1u);
  expect_failure(run_program("ld_inspect", {data + "/none"}), 1, {"no such path"});
  expect_failure(run_program("ld_inspect", {}), 2, {"expected a path or --keys KIND", "--help"});
}

}  // namespace
}  // namespace ld
