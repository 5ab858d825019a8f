// Training configurations and scene recipes.
#include "core/config_tree.h"
#include "models/check_network.h"
#include "render/recipe/recipe.h"
#include "tests/fuzz/fuzz_file.h"
#include "training/run/config.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  const std::filesystem::path path = ld::fuzz_file("input.yaml", data, size);
  ld::expect_no_more_than_an_error([&] {
    const auto config = ld::config_from_tree<ld::TrainConfig>(ld::read_config(path));
    ld::check_network(config.network);
  });
  ld::expect_no_more_than_an_error([&] { ld::read_recipe(path, {}, std::nullopt); });
  return 0;
}
