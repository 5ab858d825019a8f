// The parts that the networks are made of (models/), in standard ONNX operators: one function for each file
// there.
#pragma once

#include "export/onnx_graph.h"
#include "models/network_config.h"

namespace ld {

/// The model's inputs, sanitised as by models/network_input.h.
struct OnnxSamples {
  Value features;  // [B, S, F, H, W]
  Value radiance;  // [B, S, 3, H, W], or the 6 channels of models/demodulation.h
  Value valid;     // [B, S, 1, H, W] float 0 or 1
  Value drawn;     // [B, 1, 1, H, W] float: 1 where the pixel has a valid sample
  int64_t radiance_channels = 3;
};

OnnxSamples onnx_sanitise(OnnxGraph& g, const Value& features, const Value& radiance, const Value& valid);

/// models/exposure.h: `features` with those of the radiance, which begin at `channel`, made from the exposed
/// radiance. In float32, where the C++ network computes the exposure in float64.
Value onnx_exposed(OnnxGraph& g, const OnnxSamples& samples, int64_t channel, int64_t channels);

/// models/pixel_mean.h; `channel` is -1 where radiance is no feature.
OnnxSamples onnx_pixel_mean(OnnxGraph& g, const OnnxSamples& samples, int64_t channel, int64_t channels);

/// models/demodulation.h: a_s [B, S, 3, H, W]; the samples with their radiance in both forms; the step after
/// the filter, from its result [B, 6, H, W], a_s and the context.
Value onnx_demodulator(OnnxGraph& g, const NetworkConfig& config, const Value& features);
OnnxSamples onnx_demodulated(OnnxGraph& g, const OnnxSamples& samples, const Value& demodulator);
Value onnx_modulated(OnnxGraph& g, const OnnxSamples& samples, const Value& demodulator,
                     const Value& filtered, const Value& context);

/// Weights `name`.0, .1, ..., of so many layers.
struct OnnxLayers {
  std::string name;
  size_t layers = 0;
  bool activate_last = false;
  int64_t own_inputs = 0;         // channels of x; a context brings the others
  int64_t first = 0, count = -1;  // outputs of the last layer; -1: all
  double bound = 0;               // of the last layer's results; 0: none
};

/// ops/fully_connected.h: x [B, S, X, H, W] and `context` [B, Y, H, W] or nothing -> [B, S, outputs, H, W].
Value onnx_fully_connected(OnnxGraph& g, const OnnxLayers& network, const Value& x,
                           const Value& context = {});

/// Mean over the valid samples, [B, S, C, H, W] -> [B, C, H, W] (ops/weighted_sum.h).
Value onnx_masked_mean(OnnxGraph& g, const Value& values, const Value& valid);

/// models/sample_statistics.h: values [B, S, F, H, W], valid -> [B, 1, 2F, H, W].
Value onnx_sample_statistics(OnnxGraph& g, const Value& values, const Value& valid);

/// Pictures scaled up by a power of two, as the U-net does it.
Value onnx_upsample(OnnxGraph& g, const Value& picture, int64_t factor, const UNetConfig& config);

/// UNet::features (models/unet.h).
std::vector<Value> onnx_unet(OnnxGraph& g, const UNetConfig& config, const Value& input, int64_t resolutions);

/// ops/partition.h, without the opacity, which no filter needs.
struct OnnxPartition {
  Value log_n;          // [B, N, 1, H, W]
  Value radiance;       // [B, N, C, H, W]
  Value transmittance;  // [B, N, 1, H, W]; none for the weighted compositor
  Value embedding;      // [B, N, E, H, W]
};
OnnxPartition onnx_partition(OnnxGraph& g, const NetworkConfig& config, const Value& logits,
                             const OnnxSamples& samples, const Value& embedding);

/// models/networks/layer_pyramid.h.
struct OnnxPyramidLevel {
  OnnxPartition layers;
  Value pixels;  // [B, 1, 1, H, W]
};
std::vector<OnnxPyramidLevel> onnx_pyramid(OnnxGraph& g, const OnnxPartition& layers, int64_t levels);

}  // namespace ld
