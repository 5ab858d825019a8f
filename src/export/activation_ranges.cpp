#include "export/activation_ranges.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <numeric>

#include "runtime/executor.h"

namespace ld {
namespace {

uint32_t magnitude_bits(float x) {
  uint32_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return bits & 0x7fffffffU;
}

}  // namespace

ActivationRanges::ActivationRanges(const NetworkWeights& network) : network_(network) {
  for (const graph::Node& node : network.graph.nodes)
    if (std::holds_alternative<graph::Convolution>(node.op))
      for (const graph::ValueId input : node.inputs) seen_[input] = {};
}

void ActivationRanges::add_rows(graph::ValueId value, const RowWindow& rows, int64_t begin, int64_t end) {
  const auto found = seen_.find(value);
  if (found == seen_.end()) return;
  for (int64_t y = begin; y < end; ++y)
    for (int64_t plane = 0; plane < rows.planes; ++plane)
      std::for_each_n(rows.row(y, plane), rows.width,
                      [&](float x) { ++found->second[magnitude_bits(x) >> kBinShift]; });
}

void ActivationRanges::add(const Frame& frame, int threads) {
  ExecutionOptions options;
  options.threads = threads;
  options.made = [&](graph::ValueId value, const RowWindow& rows, int64_t begin, int64_t end) {
    add_rows(value, rows, begin, end);
  };
  Execution(network_.graph, network_.weights, {frame.spp, frame.height, frame.width}, options).run(frame);
}

float ActivationRanges::of(const graph::Node& convolution) const {
  Histogram sum = {};
  for (const graph::ValueId input : convolution.inputs)
    std::transform(sum.begin(), sum.end(), seen_.at(input).begin(), sum.begin(), std::plus<>());
  const double all = double(std::accumulate(sum.begin(), sum.end(), uint64_t(0)));
  uint64_t beyond = 0;
  size_t bin = sum.size() - 1;
  for (; bin > 0; --bin)
    if (double(beyond += sum[bin]) > kBeyondRange * all) break;
  if (bin == 0) return 0;
  const auto bits = uint32_t(bin + 1) << kBinShift;  // where the next bin begins
  float edge = 0;
  std::memcpy(&edge, &bits, sizeof edge);
  return edge;
}

}  // namespace ld
