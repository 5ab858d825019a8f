#include "export/onnx_export.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/file_io.h"
#include "dataset/input_tensors.h"
#include "export/onnx_evaluator.h"
#include "export/onnx_file.h"
#include "export/onnx_network.h"
#include "models/check_network.h"
#include "tests/models/small_network.h"
#include "tests/support/expect_error.h"
#include "tests/support/moving_frame.h"
#include "tests/support/run_program.h"
#include "weights/model_file.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

using torch::Tensor;

/// Of every_config(): as it is, with nearest upsampling, with more layers and larger
/// kernels, with one tap, with exposure normalisation, of means.
std::vector<NetworkConfig> exported_configs() {
  std::vector<NetworkConfig> configs;
  for (NetworkConfig config : every_config()) {
    configs.push_back(config);
    config.kernel_size = 7;
    config.unet.upsampling = "nearest";
    config.exposure_normalisation = may_be_exposed(config);
    if (has_layers(config)) config.layers = 3;
    if (network_traits(config.name).has_levels) config.levels = 2;
    config.sample_partitioner = {};
    configs.push_back(config);
    config.kernel_size = 1;
    config.kernel_generator = {};
    config.exposure_normalisation = false;
    configs.push_back(config);
    if (!works_on_pixels(config)) continue;
    config.means = true;
    configs.push_back(config);
  }
  return configs;
}

class OnnxExportTest : public ::testing::Test {
 protected:
  /// The model as exported and read back.
  onnx::ModelProto exported(const NetworkConfig& config, double logit_scale = 1) {
    source_ = {small_network(config, torch::kFloat32), R"({"steps": 3})"};
    if (logit_scale != 1) scale_logits(*source_.network, logit_scale);
    report_ = export_onnx(source_, path(), DType::f32, {random_input(config, 1, 2, 5, 6, torch::kFloat32)});
    return parse_onnx(read_file(path()), path().string());
  }
  std::filesystem::path path() const { return folder_ / "model.onnx"; }

  /// Of a first frame, of networks that remember.
  Tensor forward(const OnnxEvaluator& evaluator, const NetworkInput& input) const {
    std::vector<Tensor> state = empty_onnx_state(source_.network->config(), input);
    return evaluator.forward(input, state);
  }

  void expect_same(const OnnxEvaluator& evaluator, const NetworkInput& input, const std::string& what) {
    const torch::InferenceMode no_graph;
    const Tensor expected = source_.network->forward(input), found = forward(evaluator, input);
    ASSERT_EQ(found.sizes(), expected.sizes()) << what;
    EXPECT_LT(largest_relative_difference({found}, {expected}), 1e-4) << what;
  }

  TemporaryFolder folder_;
  ExportSource source_;
  OnnxExport report_;
};

TEST_F(OnnxExportTest, EveryNetworkAtEverySizeComputesWhatItDoesInCpp) {
  for (const NetworkConfig& config : exported_configs()) {
    const OnnxEvaluator evaluator(exported(config));
    EXPECT_LT(report_.graph.largest_relative_difference, 1e-4) << title(config);
    EXPECT_EQ(report_.weights.largest_relative_difference, 0);
    const std::vector<std::vector<int64_t>> sizes = {
        {1, 1, 1, 1}, {1, 1, 5, 3}, {2, 3, 16, 16}, {1, 4, 13, 21}, {3, 2, 7, 10}};
    for (const auto& s : sizes)
      expect_same(evaluator, random_input(config, s[0], s[1], s[2], s[3], torch::kFloat32, 7),
                  title(config) + " " + std::to_string(s[2]) + "x" + std::to_string(s[3]));
  }
}

TEST_F(OnnxExportTest, PicturesWithoutSamplesAndFaultySamplesAreAsInCpp) {
  for (const NetworkConfig& config : every_config()) {
    const OnnxEvaluator evaluator(exported(config));
    NetworkInput input = random_input(config, 1, 2, 9, 8, torch::kFloat32, 3);
    const NetworkInput none = {input.features, input.radiance, torch::zeros_like(input.valid)};
    EXPECT_EQ(forward(evaluator, none).abs().max().item<float>(), 0) << title(config);
    input.features[0][0][1][4][4] = std::nanf("");
    input.radiance[0][1][2][3][3] = std::numeric_limits<float>::infinity();
    input.radiance[0][1][0][2][2] = -5;
    input.radiance[0][0][0][1][1] = 3e38F;
    input.features[0][0][2][6][6] = 1e20F;
    // A block of pixels, larger than the kernel, that has no sample.
    input.valid.narrow(3, 0, 4).narrow(4, 0, 4).zero_();
    expect_same(evaluator, input, title(config));
  }
}

TEST_F(OnnxExportTest, LargeLogitsLoseNoEnergy) {
  for (const NetworkConfig& config : averaging_configs()) {
    const OnnxEvaluator evaluator(exported(config, 30));
    NetworkInput input = with_one_reflectance(random_input(config, 1, 3, 12, 11, torch::kFloat32, 5), config);
    input.valid.fill_(1);
    input.radiance.fill_(2);
    const Tensor image = forward(evaluator, input);
    EXPECT_LT((image - 2).abs().max().item<float>(), 2e-4) << title(config);
  }
}

/// Two sequences, for a history whose surfaces move where it reads flow; some samples are missing.
NetworkInput frame_of_sequences(const NetworkConfig& config, int height, int width, uint32_t number) {
  if (config.name != "layer_history")
    return random_input(config, 2, 2, height, width, torch::kFloat32, 100 + 10 * number);
  NetworkInput input = make_network_input(
      {moving_frame(width, height, 3, number), moving_frame(width, height, 3, 500 + number)},
      config.features);
  input.valid = input.valid * random_valid(2, 3, height, width, 70 + number).to(torch::kFloat32);
  return input;
}

// The state is inputs and outputs of the model: twenty frames, each behind what the one before has left.
TEST_F(OnnxExportTest, AStateGoesFromFrameToFrame) {
  int remembering = 0;
  for (const NetworkConfig& config : every_network()) {
    if (!network_traits(config.name).remembers) continue;
    const onnx::ModelProto model = exported(config);
    std::vector<std::string> parts;
    if (config.name == "layer_history") parts = {"light", "frames", "surface"};
    if (config.name == "recurrent" && config.recurrence) parts = {"h0", "h1", "h2"};
    remembering += parts.empty() ? 0 : 1;
    ASSERT_EQ(size_t(model.graph().input_size()), 3 + parts.size());
    ASSERT_EQ(size_t(model.graph().output_size()), 1 + parts.size());
    for (size_t part = 0; part < parts.size(); ++part) {
      EXPECT_EQ(model.graph().input(int(3 + part)).name(), onnx_state(part));
      EXPECT_EQ(model.graph().output(int(1 + part)).name(), onnx_next_state(part));
    }
    const OnnxEvaluator evaluator(model);
    const torch::InferenceMode no_graph;
    for (const auto& [h, w] : {std::pair(1, 1), std::pair(5, 3), std::pair(13, 22)}) {
      NetworkState expected_state;
      std::vector<Tensor> state;
      for (uint32_t f = 0; f < 20; ++f) {
        const NetworkInput input = frame_of_sequences(config, h, w, f);
        if (f == 0) state = empty_onnx_state(config, input);
        const Tensor expected = source_.network->forward(input, expected_state),
                     found = evaluator.forward(input, state);
        EXPECT_LT(largest_relative_difference({found}, {expected}), 1e-4)
            << title(config) << " frame " << f << " " << h << "x" << w;
        for (size_t part = 0; part < parts.size(); ++part)
          EXPECT_LT(largest_relative_difference({state[part]}, {expected_state.at(parts[part])}), 1e-4)
              << title(config) << " " << parts[part] << " behind frame " << f << " " << h << "x" << w;
      }
      if (config.name == "layer_history" && h == 13) {
        EXPECT_GT(state[1].mean().item<float>(), 1.2F) << title(config) << ": much has a history";
      }
    }
  }
  EXPECT_GE(remembering, 2);
}

// Where a surface is looked up: the rules of ops/kernels/warp_taps.h at the edges of what is a number.
TEST_F(OnnxExportTest, AHistoryIsLookedUpByTheSameRules) {
  NetworkConfig config = small_config();
  config.name = "layer_history";
  config.features = {"radiance", "depth", "normal", "flow"};
  const OnnxEvaluator evaluator(exported(config));
  const torch::InferenceMode no_graph;
  const int64_t flow = first_channel(config.features, "flow"),
                depth = first_channel(config.features, "depth"),
                normal = first_channel(config.features, "normal");
  // Encoded: 1 and beyond is infinite, 1 / 17 a pixel, 0.5 sixteen.
  for (const float moved :
       {0.0F, 1e-38F, -1e-42F, 1.0F / 17, -1.0F / 17, 0.03F, 0.5F, 0.9999F, 1.0F, -1.0F, 65504.0F, -65504.0F})
    for (const float deep : {0.0F, 0.5F, 0.55F, 0.6F, 0.999F, 1.0F})
      for (const float turned : {0.0F, 1.0F, -1.0F, 3e-20F}) {
        NetworkInput before = random_input(config, 1, 2, 6, 7, torch::kFloat32, 3);
        before.valid.fill_(1);
        before.features.narrow(2, depth, 1).fill_(0.5);
        before.features.narrow(2, normal, 3).fill_(1);
        before.features.narrow(2, flow, 2).zero_();
        NetworkInput now = {before.features.clone(), before.radiance * 1.25, before.valid};
        now.features.narrow(2, flow, 2).fill_(moved);
        now.features.narrow(2, depth, 1).fill_(deep);
        now.features.narrow(2, normal, 3).fill_(turned);
        NetworkState expected_state;
        std::vector<Tensor> state = empty_onnx_state(config, before);
        source_.network->forward(before, expected_state);
        evaluator.forward(before, state);
        const Tensor expected = source_.network->forward(now, expected_state),
                     found = evaluator.forward(now, state);
        EXPECT_LT(
            largest_relative_difference({found, state[1], state[2]}, {expected, expected_state.at("frames"),
                                                                      expected_state.at("surface")}),
            1e-4)
            << moved << " " << deep << " " << turned;
      }
}

TEST_F(OnnxExportTest, TheFileSaysWhatItIsAndWhatWasMeasured) {
  const NetworkConfig config = small_config();
  const onnx::ModelProto model = exported(config);
  EXPECT_EQ(model.opset_import(0).version(), 15);
  ASSERT_EQ(model.graph().input_size(), 3);
  EXPECT_EQ(model.graph().input(0).name(), "features");
  EXPECT_EQ(model.graph().input(0).type().tensor_type().shape().dim(2).dim_value(),
            channel_count(config.features));
  EXPECT_EQ(model.graph().output(0).name(), "image");
  std::map<std::string, std::string> metadata;
  for (const auto& entry : model.metadata_props()) metadata[entry.key()] = entry.value();
  EXPECT_EQ(metadata.at("format"), "ld-onnx");
  EXPECT_EQ(metadata.at("network"), config_to_yaml(config));
  EXPECT_EQ(metadata.at("features"), describe_features(config.features));
  EXPECT_EQ(metadata.at("provenance"), R"({"steps": 3})");
  EXPECT_NE(metadata.at("export").find(R"("onnx":{"largest_relative_difference":)"), std::string::npos);
  // The weights by their names, and little else: the graph itself is small.
  std::set<std::string> names;
  for (const auto& tensor : model.graph().initializer()) names.insert(tensor.name());
  for (const auto& parameter : source_.network->named_parameters())
    EXPECT_EQ(names.count(parameter.key()), 1U) << parameter.key();
}

TEST_F(OnnxExportTest, HalfWeightsHalveTheFile) {
  NetworkConfig config = small_config();
  config.kernel_generator = {100, 100};
  source_ = {small_network(config, torch::kFloat32), ""};
  const std::vector<NetworkInput> inputs = {random_input(config, 1, 2, 9, 9, torch::kFloat32)};
  export_onnx(source_, folder_ / "f32.onnx", DType::f32, inputs);
  const OnnxExport half = export_onnx(source_, folder_ / "f16.onnx", DType::f16, inputs);
  EXPECT_GT(half.weights.largest_relative_difference, 0);
  EXPECT_LT(half.weights.largest_relative_difference, kHalfTolerance);
  EXPECT_LT(half.graph.largest_relative_difference, 1e-4);
  const auto whole = file_size(folder_ / "f32.onnx"), small = file_size(folder_ / "f16.onnx");
  EXPECT_LT(small, whole - 20000);
}

TEST_F(OnnxExportTest, MoreThanTheAllowedDifferenceLeavesNothing) {
  source_ = {small_network(small_config(), torch::kFloat32), ""};
  EXPECT_ERROR(export_onnx(source_, path(), DType::f32, parity_inputs(small_config(), {}), 1e-12),
               "computes something else than the network");
  EXPECT_FALSE(exists(path()));
}

TEST_F(OnnxExportTest, DamagedModelsAreRefusedInOneLine) {
  exported(small_config());
  const std::string bytes = read_file(path());
  EXPECT_ERROR(parse_onnx(bytes.substr(0, bytes.size() / 2), "m.onnx"), "m.onnx: no ONNX model");
  EXPECT_ERROR(parse_onnx("", "m.onnx"), "m.onnx: no ONNX model");
  std::string renamed = bytes;  // an operator that does not exist
  renamed.replace(renamed.find("LeakyRelu"), 9, "LeakyRelo");
  EXPECT_ERROR(parse_onnx(renamed, "m.onnx"), "m.onnx: not a valid ONNX model: ");
  EXPECT_ERROR(load_source(path()), "model.onnx");
}

TEST_F(OnnxExportTest, TheProgramExportsAndPrintsTheDifference) {
  write_file_atomically(folder_ / "train.yaml",
                        "network:\n  features: [radiance, albedo]\n  kernel_size: 3\n  sample_reducer: [4]\n"
                        "  sample_partitioner: [4]\n  kernel_generator: [4]\n"
                        "  unet: {encoder: [[4], [4]], bottleneck: [4], decoder: [[4], [4]], context: 4}\n");
  const std::string out = path().string(), data = (folder_ / "check.safetensors").string();
  const ProgramResult result =
      run_program("ld_export", {"--untrained", (folder_ / "train.yaml").string(), "--format", "onnx", "--out",
                                out, "--check-data", data});
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_NE(result.output.find("ONNX graph and C++ network: largest relative difference"), std::string::npos)
      << result.output;
  const SafetensorsFile check(data);
  EXPECT_EQ(check.tensor("image_1").shape, (std::vector<int64_t>{2, 3, 16, 16}));
  const OnnxEvaluator evaluator(parse_onnx(read_file(out), out));
  const NetworkInput input = {read_tensor(check.tensor("features_1")),
                              read_tensor(check.tensor("radiance_1")), read_tensor(check.tensor("valid_1"))};
  EXPECT_LT(largest_relative_difference({evaluator.forward(input)}, {read_tensor(check.tensor("image_1"))}),
            1e-4);
  expect_failure(run_program("ld_export", {"--format", "onnx", "--out", out}), 2, {"--model or --untrained"});
}

}  // namespace
}  // namespace ld
