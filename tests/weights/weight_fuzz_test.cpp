// Thousands of damaged weight files: each is read or gives one clear line, and nothing beyond the file is
// read. tests/weights/model_damage_test.cpp goes on to the network.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "core/error.h"
#include "core/file_io.h"
#include "tests/support/damage.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/weight_damage.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// A file with the header of a small network, and a few tensors.
std::string good_file(const fs::path& path) {
  NetworkConfig network;
  network.features = {"radiance", "albedo"};
  network.unet.encoder = {{8, 8}, {16}};
  network.unet.decoder = {{16}, {8}};
  const std::vector<float> floats(24, 0.5F);
  const std::vector<uint16_t> halves(15, 0x3c00);
  write_safetensors(path,
                    {{"unet.encoder0.0.weight", DType::f32, {2, 3, 2, 2}, floats.data(), 96},
                     {"unet.encoder0.0.bias", DType::f32, {2}, floats.data(), 8},
                     {"sample_reducer.weight", DType::f16, {5, 3}, halves.data(), 30},
                     {"empty", DType::u8, {0, 4}, nullptr, 0}},
                    make_weights_metadata(network, R"({"steps": 40})"));
  return read_file(path);
}

/// False when it gave an Error, which must be one clear line.
bool read_whole(const fs::path& path, const std::string& bytes) {
  try {
    const SafetensorsFile file(path);
    // The views lie in the file, one behind the other up to its end.
    size_t total = 0;
    for (const TensorView& tensor : file.tensors()) total += tensor.bytes;
    EXPECT_LE(total + 8, bytes.size());
    const char* at = bytes.data() + bytes.size() - total;
    for (const TensorView& tensor : file.tensors()) {
      EXPECT_EQ(std::string(static_cast<const char*>(tensor.bytes > 0 ? tensor.data : ""), tensor.bytes),
                std::string(at, tensor.bytes));
      at += tensor.bytes;
    }
    const WeightsHeader header = read_weights_header(file);
    EXPECT_FALSE(header.network.name.empty());
    return true;
  } catch (const Error& error) {
    expect_clear(error.what(), path.filename().string());
    return false;
  }
}

TEST(WeightFuzz, DamagedFilesAreReadOrGiveOneLine) {
  const TemporaryFolder folder;
  const std::string good = good_file(folder / "good.safetensors");
  const fs::path path = folder / "fuzz.safetensors";
  ASSERT_TRUE(read_whole(folder / "good.safetensors", good));
  int errors = 0;
  run_trials(3000, [&](uint32_t number, RandomStream& random) {
    const std::string bytes = damaged_weights(good, number, random);
    write_new_file(path, bytes);
    if (!read_whole(path, bytes)) ++errors;
  });
  EXPECT_GT(errors, 1500);
  EXPECT_LT(errors, 3000) << "some damages do no harm";
}

TEST(WeightFuzz, HeadersThatAreMadeToTakeLongAreRefusedSoon) {
  const TemporaryFolder folder;
  const fs::path path = folder / "slow.safetensors";
  const auto refused = [&](const std::string& what, const std::string& header) {
    const auto start = std::chrono::steady_clock::now();
    const std::string bytes = with_header_length(header) + header;
    write_new_file(path, bytes);
    EXPECT_FALSE(read_whole(path, bytes)) << what;
    EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 5) << what;
  };
  const std::string megabyte(1 << 20, '[');
  refused("deep lists", megabyte);
  refused("deep objects", [] {
    std::string text;
    while (text.size() < (1 << 20)) text += "{\"a\":";
    return text;
  }());
  refused("one long name", "{\"" + std::string(1 << 20, 'n') + "\": 1}");
  refused("a long shape", [] {
    std::string text = R"({"t": {"dtype": "U8", "data_offsets": [0, 0], "shape": [2)";
    while (text.size() < (1 << 20)) text += ",2";
    return text + "]}}";
  }());
  refused("many tensors", [] {
    std::string text = "{";
    for (int i = 0; text.size() < (1 << 20); ++i)
      text += fmt::format(R"("t{}": {{"dtype": "U8", "shape": [1], "data_offsets": [0, 1]}}, )", i);
    return text + "\"u\": 1}";
  }());
  // The network's YAML is the header's text of any length.
  for (const std::string& item : {std::string("[1], "), std::string("1, "), std::string("[")}) {
    std::string list;
    while (list.size() < (3 << 20)) list += item;
    Metadata metadata = make_weights_metadata(NetworkConfig{}, "");
    metadata["network"] = "unet: {encoder: [" + list + "]}";
    refused("a long network", nlohmann::json({{"__metadata__", metadata}}).dump());
  }
}

}  // namespace
}  // namespace ld
