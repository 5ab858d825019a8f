// A checkpoint to one deployable weight file, and the proof that the file still computes the same.
#pragma once

#include <filesystem>
#include <vector>

#include "export/parity.h"

namespace ld {

/// Writes the network's weights to `out` as f32 or f16, atomically, after measuring on `inputs` what the
/// number format changes; the metadata holds it. Throws Error when that is more than is allowed or the file
/// does not give back what was written; then nothing is left behind.
Parity export_safetensors(const ExportSource& source, const std::filesystem::path& out, DType type,
                          const std::vector<NetworkInput>& inputs);

/// What rounding the weights to `type` changes. Throws Error when it is more than kHalfTolerance.
Parity rounding_parity(const ExportSource& source, Network& rounded, DType type,
                       const std::vector<NetworkInput>& inputs);

}  // namespace ld
