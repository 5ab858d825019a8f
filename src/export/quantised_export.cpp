#include "export/quantised_export.h"

#include <half.h>

#include <chrono>
#include <cmath>

#include "core/error.h"
#include "core/file_io.h"
#include "core/progress.h"
#include "evaluation/data_set.h"
#include "metrics/smape.h"
#include "runtime/executor.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

NamedWeight as_half(const std::string& name, NamedWeight weight) {
  for (float& value : weight.values) {
    const float rounded = half(value);
    if (!std::isfinite(rounded))
      fail("parameter '{}' reaches {}, beyond the largest float16, 65504; export with --dtype f32", name,
           value);
    value = rounded;
  }
  return weight;
}

// Other frames may be brighter than those that were calibrated on.
constexpr float kHeadroom = 2;
constexpr float kLeastRange = 1e-6F;  // of activations that were all 0

/// A picture and the time it took.
struct Timed {
  Image image;
  double milliseconds;
};
Timed run(const NetworkWeights& network, const Frame& frame, int threads) {
  Execution execution(network.graph, network.weights, {frame.spp, frame.height, frame.width}, {threads});
  execution.run(frame);  // memory is new in the first run
  const auto start = std::chrono::steady_clock::now();
  Image image = std::move(execution.run(frame)[0]);
  return {std::move(image),
          std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count()};
}

QuantisedMeasure measure(const NetworkWeights& network, const NetworkWeights& int8, const FrameSet& frames,
                         int threads) {
  QuantisedMeasure sum;
  sum.frames = frames.count;
  Progress progress("frames to compare", int64_t(frames.count));
  for (size_t i = 0; i < frames.count; ++i) {
    const EvaluationFrame given = frames.load(i);
    const Timed former = run(network, given.frame, threads), made = run(int8, given.frame, threads);
    const double share = 1 / double(frames.count);
    sum.smape_float32 += share * smape(former.image, given.reference);
    sum.smape_int8 += share * smape(made.image, given.reference);
    sum.ms_a_frame_float32 += share * former.milliseconds;
    sum.ms_a_frame_int8 += share * made.milliseconds;
    progress.advance();
  }
  return sum;
}

void write_network(const std::filesystem::path& path, const NetworkWeights& network,
                   const Metadata& metadata) {
  std::vector<std::vector<unsigned short>> halves;  // keeps what is written alive
  std::vector<TensorView> tensors;
  const std::vector<graph::Parameter> parameters = graph::parameters(network.graph);
  halves.reserve(parameters.size());
  for (const graph::Parameter& parameter : parameters) {
    const NamedWeight& weight = network.weights.at(parameter.name);
    if (weight.quantised) {
      const Quantised& q = *weight.quantised;
      tensors.push_back({parameter.name, DType::i8, weight.shape, q.levels.data(), q.levels.size()});
      tensors.push_back({parameter.name + ".scale",
                         DType::f32,
                         {int64_t(q.scales.size())},
                         q.scales.data(),
                         q.scales.size() * sizeof(float)});
      tensors.push_back({parameter.name + ".input_range", DType::f32, {1}, &q.input_range, sizeof(float)});
      continue;
    }
    std::vector<unsigned short>& bits = halves.emplace_back();
    for (const float value : weight.values) bits.push_back(half(value).bits());
    tensors.push_back({parameter.name, DType::f16, weight.shape, bits.data(), bits.size() * sizeof(bits[0])});
  }
  write_safetensors(path, tensors, metadata);
}

}  // namespace

NetworkWeights quantised(const NetworkWeights& network, const ActivationRanges& ranges) {
  NetworkWeights made = {network.config, network.graph, {}};
  for (const graph::Parameter& parameter : graph::parameters(network.graph))
    made.weights.add(parameter.name, as_half(parameter.name, network.weights.at(parameter.name)));
  for (const graph::Node& node : network.graph.nodes)
    if (const auto* convolution = std::get_if<graph::Convolution>(&node.op)) {
      const std::string name = convolution->weights + ".weight";
      made.weights.add(
          name, quantised(network.weights.at(name), std::max(kHeadroom * ranges.of(node), kLeastRange)));
    }
  return made;
}

nlohmann::ordered_json to_json(const QuantisedMeasure& measure) {
  return {{"frames", measure.frames},
          {"smape_float32", measure.smape_float32},
          {"smape_int8", measure.smape_int8},
          {"ms_a_frame_float32", measure.ms_a_frame_float32},
          {"ms_a_frame_int8", measure.ms_a_frame_int8}};
}

QuantisedResult export_quantised(const QuantisedExport& options) {
  const std::filesystem::path file = resolve_model(options.model);
  const NetworkWeights network = read_network_weights(file);
  const std::vector<std::string> features = network.config.required_features();
  const FrameSet seen = open_frame_set(options.data, "train", features, options.frames);
  const FrameSet judged = open_frame_set(options.data, "validation", features, options.frames);

  ActivationRanges ranges(network);
  Progress progress("frames to calibrate on", int64_t(seen.count));
  for (size_t i = 0; i < seen.count; ++i) {
    ranges.add(seen.load(i).frame, options.threads);
    progress.advance();
  }
  const NetworkWeights int8 = quantised(network, ranges);
  QuantisedResult result;
  result.measure = measure(network, int8, judged, options.threads);
  if (!(result.measure.smape_ratio() <= 1 + options.allowed))
    fail(
        "int8 denoises worse: SMAPE {:.5f} on {} validation frames, {:.5f} in float32, which is {:.2f} % "
        "more, "
        "allowed {:.2f} %; nothing was written; export with --dtype f16, or raise --allowed",
        result.measure.smape_int8, judged.count, result.measure.smape_float32,
        100 * (result.measure.smape_ratio() - 1), 100 * options.allowed);
  result.metadata =
      make_weights_metadata(network.config, read_weights_header(SafetensorsFile(file)).provenance);
  result.metadata["export"] =
      nlohmann::ordered_json({{"program", "ld_export " LD_VERSION},
                              {"dtype", "i8"},
                              {"calibration", {{"data", options.data.string()}, {"frames", seen.count}}},
                              {"validation", to_json(result.measure)},
                              {"allowed", options.allowed},
                              {"threads", options.threads}})
          .dump();
  write_atomically(options.out, [&](const std::filesystem::path& temporary) {
    write_network(temporary, int8, result.metadata);
    read_network_weights(temporary);
  });
  return result;
}

}  // namespace ld
