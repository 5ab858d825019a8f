// A network whose convolutions run in 8 bits, calibrated and measured on a data set. Free of LibTorch.
#pragma once

#include <filesystem>
#include <string>

#include "core/json_text.h"
#include "export/activation_ranges.h"
#include "weights/network_weights.h"
#include "weights/safetensors.h"

namespace ld {

/// The weights of convolutions in 8 bits (weights/named_weights.h) with activations that `ranges` saw;
/// everything else as float16 keeps it. Throws Error for a weight beyond float16.
NetworkWeights quantised(const NetworkWeights& network, const ActivationRanges& ranges);

/// What two networks make of the same frames.
struct QuantisedMeasure {
  size_t frames = 0;
  double smape_float32 = 0, smape_int8 = 0;  // means over the frames
  double ms_a_frame_float32 = 0, ms_a_frame_int8 = 0;
  double smape_ratio() const { return smape_int8 / smape_float32; }
  double time_ratio() const { return ms_a_frame_int8 / ms_a_frame_float32; }
};
nlohmann::ordered_json to_json(const QuantisedMeasure& measure);

/// By how much the SMAPE may be larger, as a part of it.
constexpr double kQuantisedTolerance = 0.01;

struct QuantisedExport {
  std::filesystem::path model, data, out;
  double allowed = kQuantisedTolerance;
  int threads = 1;
  size_t frames = 32;  // at most, of each split
};

struct QuantisedResult {
  QuantisedMeasure measure;
  Metadata metadata;  // of the file
};

/// Calibrates on the first frames of the data set's training split, measures on those of its validation split
/// and writes the file. Throws Error as read_network and open_frame_set do, and when the pictures are more
/// than `allowed` worse; then nothing is written.
QuantisedResult export_quantised(const QuantisedExport& options);

}  // namespace ld
