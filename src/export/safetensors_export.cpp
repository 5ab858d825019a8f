#include "export/safetensors_export.h"

#include "core/error.h"
#include "core/file_io.h"
#include "core/random.h"
#include "frame/schema.h"
#include "weights/model_file.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

/// Random features and radiance of an odd size, the same on every call.
NetworkInput parity_input(const NetworkConfig& config) {
  RandomStream stream(1, RandomPurpose::test);
  const auto random = [&](int64_t channels) {
    torch::Tensor tensor = torch::empty({1, 4, channels, 37, 41});
    float* values = tensor.data_ptr<float>();
    for (int64_t i = 0; i < tensor.numel(); ++i) values[i] = stream.uniform();
    return tensor;
  };
  return {random(channel_count(config.features)), random(3), torch::ones({1, 4, 1, 37, 41})};
}

}  // namespace

Parity export_safetensors(const std::filesystem::path& model, const std::filesystem::path& out, DType type) {
  const torch::InferenceMode no_graph;
  const std::filesystem::path source = resolve_model(model);
  const std::string provenance = read_weights_header(SafetensorsFile(source)).provenance;
  const std::shared_ptr<Network> original = load_model(source);
  const NetworkInput input = parity_input(original->config());
  const torch::Tensor expected = original->forward(input);

  Parity parity;
  // Half keeps 11 bits of each weight; some ten layers of them add up to about 2^-8. Float32 keeps every bit.
  parity.tolerance = type == DType::f16 ? 0.05 : 0;
  write_atomically(out, [&](const std::filesystem::path& temporary) {
    save_model(temporary, *original, provenance, type);
    const torch::Tensor found = load_model(temporary)->forward(input);
    parity.largest_relative_difference =
        ((found - expected).abs() / (expected.abs() + 0.01)).max().item<double>();
    if (!parity.passed())
      fail(
          "the exported weights compute something else: largest relative difference {:.2g}, allowed {:.2g}; "
          "nothing was "
          "written; export with --dtype f32",
          parity.largest_relative_difference, parity.tolerance);
  });
  return parity;
}

}  // namespace ld
