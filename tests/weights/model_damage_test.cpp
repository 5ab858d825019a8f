// Damaged weight files all the way into a network: loaded, or one clear line, without the memory that a lying
// header asks for.
#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file_io.h"
#include "core/process/process_memory.h"
#include "models/initialise.h"
#include "tests/support/expect_error.h"
#include "tests/support/sanitized.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"
#include "tests/support/weight_damage.h"
#include "weights/model_file.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

std::string good_file(const fs::path& path) {
  const auto config =
      config_from_tree<NetworkConfig>(*parse_config(tiny_network_yaml(), "tiny").find("network"));
  const std::shared_ptr<Network> network = make_network(config);
  initialise(*network, 1);
  save_network(path, *network, R"({"steps": 40})", DType::f32);
  return read_file(path);
}

TEST(ModelDamage, DamagedFilesAreLoadedOrGiveOneLine) {
  const TemporaryFolder folder;
  const std::string good = good_file(folder / "good.safetensors");
  load_network(folder / "good.safetensors");
  const int64_t before = peak_resident_bytes();
  const fs::path path = folder / "fuzz.safetensors";
  int errors = 0;
  run_trials(900, [&](uint32_t number, RandomStream& random) {
    write_new_file(path, damaged_weights(good, number, random));
    try {
      EXPECT_GT(load_network(path)->parameters().size(), 10u);
    } catch (const Error& error) {
      ++errors;
      expect_clear(error.what(), "fuzz.safetensors");
    }
  });
  EXPECT_GT(errors, 500);
  EXPECT_LT(errors, 900) << "some damages do no harm";
  if (!kAddressSanitizer) {
    EXPECT_LT(peak_resident_bytes() - before, 100 << 20);
  }
}

/// The good file with another network in its metadata.
void write_with_network(const fs::path& path, const std::string& good, const NetworkConfig& network) {
  uint64_t length = 0;
  std::memcpy(&length, good.data(), 8);
  nlohmann::json json = nlohmann::json::parse(good.substr(8, length));
  json["__metadata__"] = make_weights_metadata(network, "");
  const std::string header = json.dump();
  write_new_file(path, with_header_length(header) + header + good.substr(8 + length));
}

TEST(ModelDamage, AbsurdSizesAreRefusedBeforeTheyTakeMemory) {
  const TemporaryFolder folder;
  const std::string good = good_file(folder / "good.safetensors");
  const fs::path path = folder / "absurd.safetensors";
  const int64_t before = peak_resident_bytes();
  const auto refused = [&](const NetworkConfig& network) {
    write_with_network(path, good, network);
    EXPECT_ERROR(load_network(path), "absurd.safetensors");
    if (!kAddressSanitizer) {
      EXPECT_LT(peak_resident_bytes() - before, 100 << 20);
    }
  };
  std::vector<std::string> names = network_names();
  names.emplace_back("none");
  for (const std::string& name : names) {
    NetworkConfig network;
    network.name = name;
    refused(network);  // the published sizes, far more than the file holds
    network.unet.encoder = {{4096, 4096}, {4096, 4096}};
    network.unet.bottleneck = {4096, 4096, 4096};
    network.unet.decoder = {{4096}, {4096}};
    refused(network);
  }
  NetworkConfig many;
  many.unet.encoder.assign(70000, {1});  // sizes of pictures would overflow, too
  many.unet.decoder.assign(70000, {1});
  refused(many);
  many = NetworkConfig{};
  many.sample_reducer.assign(5000, 4096);
  many.kernel_generator.assign(5000, 4096);
  refused(many);
}

}  // namespace
}  // namespace ld
