// What an exported file is measured with: the inputs, the difference, and how it is written down.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "models/network.h"
#include "weights/safetensors.h"

namespace ld {

/// The network that is to be exported and where it came from (JSON, as in weights/weight_file.h).
struct ExportSource {
  std::shared_ptr<Network> network;
  std::string provenance;
};

/// A weight file, checkpoint or run folder (its averaged weights where the training averaged).
ExportSource load_source(const std::filesystem::path& model);
/// Averages its weights with those of another (weights/mix_weights.h) and says so in the provenance.
void mix_in(const std::filesystem::path& model, double share, ExportSource& source);
/// The `network:` section of a training configuration with random weights: to try and time a runtime before
/// anything is trained.
ExportSource untrained_source(const std::filesystem::path& config, uint64_t seed);

/// Three random pictures of odd and even sizes, the same on every call: some samples masked, a pixel without
/// any, a few bright ones. Then the frames of these files.
std::vector<NetworkInput> parity_inputs(const NetworkConfig& config,
                                        const std::vector<std::filesystem::path>& frames);

/// A copy of the network with each weight rounded to `type`; f32 keeps them. Throws Error, naming it, when a
/// weight is too large for f16.
std::shared_ptr<Network> rounded(const Network& network, DType type);

/// The outputs for all inputs, without a graph. A network that remembers sees each so many times in a row.
std::vector<torch::Tensor> outputs(Network& network, const std::vector<NetworkInput>& inputs, int frames = 1);
/// Frames of a sequence that differences are measured behind, of networks that remember.
constexpr int kParityFrames = 4;

/// Differences to values much smaller than this are measured as differences, those to larger ones in parts.
constexpr double kParityEpsilon = 0.01;

/// The largest |found - expected| / (|expected| + kParityEpsilon) over pictures, pixels and channels;
/// infinity where something is not finite.
double largest_relative_difference(const std::vector<torch::Tensor>& found,
                                   const std::vector<torch::Tensor>& expected);

/// A measured difference and what the number format or the other implementation may make of it.
struct Parity {
  double largest_relative_difference = 0;
  double tolerance = 0;
  bool passed() const { return largest_relative_difference <= tolerance; }
};

/// Half keeps 11 bits of each weight, which some ten layers add up: the quickstart's network changes by 0.012
/// on its test frames (docs/export.md).
constexpr double kHalfTolerance = 0.05;
/// float32 arithmetic in another order.
constexpr double kOnnxTolerance = 1e-4;

/// The metadata of an exported file: that of weights (weights/weight_file.h) and the entry "export", JSON
/// with the number format and the differences measured on so many pictures.
Metadata export_metadata(const ExportSource& source, DType type, const Parity& weights, const Parity* onnx,
                         size_t pictures);

}  // namespace ld
