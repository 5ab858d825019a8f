// Networks whose convolutions run in 8 bits: weights, files, damage, and pictures at extremes.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/file_io.h"
#include "export/quantised_export.h"
#include "models/graphs/network_graph.h"
#include "ops/kernels/instruction_sets.h"
#include "runtime/executor.h"
#include "tests/models/small_config.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"
#include "tests/support/weight_damage.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

NetworkConfig tiny_config(const std::string& name) {
  NetworkConfig config = small_config();
  config.name = name;
  return config;
}

NetworkWeights random_network(const std::string& name) {
  NetworkWeights network = {tiny_config(name), network_graph(tiny_config(name)), {}};
  RandomStream random(3, RandomPurpose::test);
  for (const graph::Parameter& parameter : graph::parameters(network.graph)) {
    const int64_t count = graph::count_of(parameter);
    NamedWeight weight = {parameter.shape, {}};
    for (int64_t i = 0; i < count; ++i) weight.values.push_back(random.uniform(-0.5F, 0.5F));
    network.weights.add(parameter.name, std::move(weight));
  }
  return network;
}

NetworkWeights calibrated(const NetworkWeights& network) {
  ActivationRanges ranges(network);
  ranges.add(random_frame(24, 20, 2), 1);
  return quantised(network, ranges);
}

Image run(const NetworkWeights& network, const Frame& frame, const ExecutionOptions& options = {}) {
  return Execution(network.graph, network.weights, {frame.spp, frame.height, frame.width}, options)
      .run(frame)[0];
}

const std::vector<std::string> kNetworks = {"layer",         "optimized",    "pixel_splat",
                                            "pixel_pyramid", "pixel_gather", "sample_splat"};

TEST(QuantisedWeight, EachOutputIsOffByHalfALevelAtMost) {
  NamedWeight weight = {{5, 2, 1}, {1.0F, -0.3F, 65504.0F, 1.0F, 0.0F, 0.0F, 1e-38F, 1e-40F, -1e-6F, 3e-7F}};
  const NamedWeight made = quantised(weight, 2.5F);
  ASSERT_TRUE(made.quantised);
  EXPECT_EQ(made.shape, weight.shape);
  EXPECT_EQ(made.quantised->input_range, 2.5F);
  EXPECT_EQ(made.quantised->levels[0], 127);
  EXPECT_EQ(made.quantised->levels[1], -38);
  EXPECT_EQ(made.quantised->levels[4], 0);
  for (size_t i = 0; i < weight.values.size(); ++i)
    EXPECT_NEAR(made.values[i], weight.values[i], 0.5001 * double(made.quantised->scales[i / 2])) << i;
}

TEST(ActivationRanges, OnePixelThatReachesFarWidensNone) {
  const NetworkWeights network = random_network("layer");
  const auto first = std::find_if(
      network.graph.nodes.begin(), network.graph.nodes.end(),
      [](const graph::Node& node) { return std::holds_alternative<graph::Convolution>(node.op); });
  ASSERT_NE(first, network.graph.nodes.end());
  const auto range = [&](const Frame& frame) {
    ActivationRanges ranges(network);
    ranges.add(frame, 1);
    return ranges.of(*first);
  };
  Frame frame = random_frame(160, 120, 1);
  const float plain = range(frame);
  EXPECT_GT(plain, 0);
  // A guide enters as it is: all that is computed of this pixel is ten thousands of times larger.
  frame.plane(0, kNormalOffset)[size_t(60 * 160 + 80)] = 65504;
  EXPECT_LT(range(frame), 1.2F * plain);
  // Not all are cut off: where half the picture reaches far, the range does.
  for (size_t i = 0; i < frame.plane_size() / 2; ++i) frame.plane(0, kNormalOffset)[i] = 65504;
  EXPECT_GT(range(frame), 100 * plain);
}

TEST(QuantisedNetwork, IsCloseToTheFloatOne) {
  for (const std::string& name : kNetworks) {
    const NetworkWeights network = random_network(name), int8 = calibrated(network);
    const Frame frame = random_frame(24, 20, 2, 9);
    const Image expected = run(network, frame), found = run(int8, frame);
    double difference = 0;
    for (size_t i = 0; i < found.pixels.size(); ++i)
      difference = std::max(difference, std::abs(double(found.pixels[i]) - double(expected.pixels[i])));
    EXPECT_GT(difference, 0) << name;
    EXPECT_LT(difference, 0.02) << name;
  }
}

TEST(QuantisedNetwork, ThreadsAndRowsAtATimeChangeNoBit) {
  const NetworkWeights int8 = calibrated(random_network("layer"));
  for (const auto& [width, height, spp] : {std::tuple{37, 53, 2}, {129, 65, 1}, {1, 1, 1}, {3, 150, 3}}) {
    const Frame frame = random_frame(width, height, spp);
    const Image expected = run(int8, frame);
    for (const int64_t rows : {1, 3, 8, 1000})
      for (const int threads : {1, 2, 3}) {
        ExecutionOptions options;
        options.threads = threads;
        options.block_rows = rows;
        EXPECT_EQ(run(int8, frame, options).pixels, expected.pixels)
            << width << "x" << height << ", " << rows << " rows, " << threads << " threads";
      }
  }
}

TEST(QuantisedNetwork, StaysAmongTheSamplesAtEveryExtreme) {
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const std::string& name : kNetworks) {
      const NetworkWeights int8 = calibrated(random_network(name));
      for (const float number :
           {0.0F, 1e-40F, 1e-38F, 65504.0F, 3e38F, -100.0F, -3e38F, std::nanf(""), kInfinity, -kInfinity})
        for (const bool in_guides : {true, false}) {
          Frame frame = random_frame(13, 11, 3);
          for (size_t i = 0; i < frame.plane_size(); ++i)
            for (int c = in_guides ? 3 : 0; c < (in_guides ? kSampleChannels : 3); ++c)
              if ((i * 7 + size_t(c)) % 5 == 0) frame.plane(int(i) % 3, c)[i] = number;
          sanitise(frame);
          float largest = 0;
          for (int s = 0; s < frame.spp; ++s)
            for (int c = 0; c < 3; ++c)
              for (size_t i = 0; i < frame.plane_size(); ++i)
                largest = std::max(largest, frame.plane(s, c)[i]);
          for (const float value : run(int8, frame).pixels) {
            ASSERT_GE(value, 0) << set << " " << name << ": " << number << " in guides: " << in_guides;
            ASSERT_LE(value, largest * 1.00001F) << set << " " << name << ": " << number;
          }
        }
    }
  }
  use_instruction_set("");
}

class QuantisedFile : public ::testing::Test {
 protected:
  void SetUp() override {
    write_tiny_dataset(folder_ / "data", 3);
    const NetworkWeights network = random_network("layer");
    std::vector<TensorView> tensors;
    for (const graph::Parameter& parameter : graph::parameters(network.graph)) {
      const NamedWeight& weight = network.weights.at(parameter.name);
      tensors.push_back({parameter.name, DType::f32, weight.shape, weight.values.data(),
                         weight.values.size() * sizeof(float)});
    }
    write_safetensors(folder_ / "f32.safetensors", tensors,
                      make_weights_metadata(network.config, R"({"steps": 3})"));
  }
  QuantisedResult exported(double allowed = 0.5) const {
    return export_quantised({folder_ / "f32.safetensors", folder_ / "data", path(), allowed});
  }
  std::filesystem::path path() const { return folder_ / "i8.safetensors"; }

  /// The exported file with `change` made to the JSON of its header.
  template <class Change>
  std::string changed(const Change& change) const {
    const std::string good = read_file(path());
    uint64_t length = 0;
    std::memcpy(&length, good.data(), 8);
    nlohmann::json json = nlohmann::json::parse(good.substr(8, length));
    std::string data = good.substr(8 + length);
    change(json, data);
    const std::string header = json.dump();
    return with_header_length(header) + header + data;
  }
  template <class Change>
  std::string error_of(const Change& change) const {
    write_new_file(folder_ / "bad.safetensors", changed(change));
    return error_text([&] { read_network_weights(folder_ / "bad.safetensors"); });
  }

  TemporaryFolder folder_;
};

TEST_F(QuantisedFile, ReadsBackAsWrittenAndSaysWhatWasMeasured) {
  const QuantisedResult result = exported();
  const NetworkWeights read = read_network_weights(path());
  const Frame frame = random_frame(16, 16, 2, 3);  // the validation frame
  EXPECT_NE(run(read, frame).pixels, run(read_network_weights(folder_ / "f32.safetensors"), frame).pixels);
  const SafetensorsFile file(path());
  EXPECT_EQ(file.tensor("unet.context.weight").type, DType::i8);
  EXPECT_EQ(file.tensor("unet.context.weight.scale").type, DType::f32);
  EXPECT_EQ(file.tensor("unet.context.bias").type, DType::f16);
  EXPECT_EQ(file.tensor("kernel_generator.0.weight").type, DType::f16);
  EXPECT_EQ(read_weights_header(file).provenance, R"({"steps": 3})");
  const auto said = nlohmann::json::parse(file.metadata_value("export"));
  EXPECT_EQ(said.at("dtype"), "i8");
  EXPECT_EQ(said.at("calibration").at("frames"), 3);
  EXPECT_EQ(said.at("validation").at("frames"), 1);
  EXPECT_EQ(said.at("validation").at("smape_int8"), result.measure.smape_int8);
  EXPECT_GT(result.measure.smape_float32, 0);
  EXPECT_GT(result.measure.ms_a_frame_int8, 0);
}

TEST_F(QuantisedFile, WhatDenoisesWorseThanAllowedIsNotWritten) {
  EXPECT_ERROR(exported(-0.9), "int8 denoises worse: SMAPE ");
  EXPECT_FALSE(exists(path()));
}

TEST_F(QuantisedFile, DamageGivesOneClearError) {
  exported();
  const std::string weight = "unet.context.weight";
  const auto expect_part = [](const std::string& text, const std::string& part) {
    EXPECT_NE(text.find(part), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
  };
  for (const std::string ending : {".scale", ".input_range"}) {
    // Elsewhere under another name, so that the bytes are still accounted for.
    expect_part(error_of([&](nlohmann::json& json, std::string&) {
                  json["else"] = json[weight + ending];
                  json.erase(weight + ending);
                }),
                "damaged");
    for (const float wrong : {0.0F, -1.0F, std::nanf(""), 1e30F, 1e-40F})
      expect_part(error_of([&](nlohmann::json& json, std::string& data) {
                    const size_t at = json[weight + ending]["data_offsets"][0];
                    std::memcpy(data.data() + at, &wrong, sizeof wrong);
                  }),
                  "'" + weight + ending + "' holds ");
  }
  expect_part(error_of([&](nlohmann::json& json, std::string&) {
                json[weight + ".scale"]["shape"] = {1, 3};
              }),
              "is not [3] of F32");
  expect_part(error_of([&](nlohmann::json& json, std::string&) { json[weight]["dtype"] = "U8"; }), "damaged");
}

TEST_F(QuantisedFile, AnyDamageIsReadOrGivesOneLine) {
  exported();
  const std::string good = read_file(path());
  const std::filesystem::path fuzzed = folder_ / "fuzz.safetensors";
  int errors = 0;
  run_trials(600, [&](uint32_t number, RandomStream& random) {
    write_new_file(fuzzed, damaged_weights(good, number, random));
    try {
      const NetworkWeights network = read_network_weights(fuzzed);
      Execution(network.graph, network.weights, {1, 3, 3});
    } catch (const Error& error) {
      ++errors;
      expect_clear(error.what(), "");
    }
  });
  EXPECT_GT(errors, 300);
  EXPECT_LT(errors, 600) << "some damages do no harm";
}

TEST_F(QuantisedFile, WhatIsNotCalibratedOnFramesIsRefused) {
  EXPECT_ERROR(export_quantised({folder_ / "f32.safetensors", folder_ / "nowhere", path(), 0.5}), "nowhere");
  EXPECT_FALSE(exists(path()));
}

}  // namespace
}  // namespace ld
