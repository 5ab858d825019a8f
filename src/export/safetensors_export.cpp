#include "export/safetensors_export.h"

#include "core/error.h"
#include "core/file_io.h"
#include "weights/model_file.h"

namespace ld {

Parity rounding_parity(const ExportSource& source, Network& rounded, DType type,
                       const std::vector<NetworkInput>& inputs) {
  Parity parity;
  parity.tolerance = type == DType::f16 ? kHalfTolerance : 0;
  parity.largest_relative_difference = largest_relative_difference(
      outputs(rounded, inputs, kParityFrames), outputs(*source.network, inputs, kParityFrames));
  if (!parity.passed())
    fail(
        "the rounded weights compute something else: largest relative difference {:.2g}, allowed {:.2g}; "
        "nothing "
        "was written; export with --dtype f32",
        parity.largest_relative_difference, parity.tolerance);
  return parity;
}

Parity export_safetensors(const ExportSource& source, const std::filesystem::path& out, DType type,
                          const std::vector<NetworkInput>& inputs) {
  const std::shared_ptr<Network> written = rounded(*source.network, type);
  const Parity parity = rounding_parity(source, *written, type, inputs);
  write_atomically(out, [&](const std::filesystem::path& temporary) {
    save_network(temporary, *written, source.provenance, type,
                 export_metadata(source, type, parity, nullptr, inputs.size()));
    const std::shared_ptr<Network> read = load_network(temporary);
    const auto expected = written->named_parameters();
    for (const auto& parameter : read->named_parameters())
      if (!parameter.value().equal(expected[parameter.key()]))
        fail("{}: parameter '{}' does not read back as written; is the disk damaged?", temporary.string(),
             parameter.key());
  });
  return parity;
}

}  // namespace ld
