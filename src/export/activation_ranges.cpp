#include "export/activation_ranges.h"

#include <algorithm>
#include <cmath>

#include "runtime/executor.h"

namespace ld {

ActivationRanges::ActivationRanges(const NetworkWeights& network) : network_(network) {
  for (const graph::Node& node : network.graph.nodes)
    if (std::holds_alternative<graph::Convolution>(node.op))
      for (const graph::ValueId input : node.inputs) largest_[input] = 0;
}

void ActivationRanges::add_rows(graph::ValueId value, const RowWindow& rows, int64_t begin, int64_t end) {
  const auto found = largest_.find(value);
  if (found == largest_.end()) return;
  for (int64_t y = begin; y < end; ++y)
    for (int64_t plane = 0; plane < rows.planes; ++plane)
      std::for_each_n(rows.row(y, plane), rows.width,
                      [&](float x) { found->second = std::max(found->second, std::abs(x)); });
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
  float largest = 0;
  for (const graph::ValueId input : convolution.inputs) largest = std::max(largest, largest_.at(input));
  return largest;
}

}  // namespace ld
