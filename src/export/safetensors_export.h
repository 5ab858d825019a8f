// A checkpoint to one deployable file, and the proof that the file still computes the same.
#pragma once

#include <filesystem>

#include "weights/safetensors.h"

namespace ld {

/// How far the exported network's output is from the original's on a fixed random frame.
struct Parity {
  double largest_relative_difference = 0;  // |a - b| / (|b| + 0.01), the largest over pixels and channels
  double tolerance = 0;                    // what the number format allows
  bool passed() const { return largest_relative_difference <= tolerance; }
};

/// Writes the weights of `model` (weight file, checkpoint or run folder) to `out` as f32 or f16, atomically,
/// after the parity check. Throws Error when the model cannot be read or the check fails; then nothing is
/// written.
Parity export_safetensors(const std::filesystem::path& model, const std::filesystem::path& out, DType type);

}  // namespace ld
