#include "runtime/demand.h"

namespace ld {
namespace {

void include(Span& span, const Span& other) {
  if (other.empty()) return;
  if (span.empty()) span = other;
  span = {std::min(span.begin, other.begin), std::max(span.end, other.end)};
}

}  // namespace

Demand::Demand(const graph::Graph& graph, const graph::PictureExtent& picture) : graph_(graph) {
  for (graph::ValueId id = 0; id < graph.values.size(); ++id) {
    const graph::ValueExtent extent = extent_of(graph, id, picture);
    widths_.push_back(extent.width);
    rows_.emplace_back(size_t(extent.height), Span{0, extent.width});
  }
}

void Demand::want_all() {
  for (size_t id = 0; id < rows_.size(); ++id)
    std::fill(rows_[id].begin(), rows_[id].end(), Span{0, widths_[id]});
}

void Demand::want(const std::vector<Span>& rows_of_output) {
  for (std::vector<Span>& rows : rows_) std::fill(rows.begin(), rows.end(), Span());
  rows_[graph_.output] = rows_of_output;
  // Every node comes behind those that it reads.
  for (auto node = graph_.nodes.rbegin(); node != graph_.nodes.rend(); ++node)
    for (const graph::ValueId output : node->outputs)
      for (int64_t y = 0; y < int64_t(rows_[output].size()); ++y) {
        const Span made = rows_[output][size_t(y)];
        if (made.empty()) continue;
        for (const graph::ValueId input : node->inputs) {
          const Span columns = pixels_read(node->op, made, widths_[input]),
                     rows = pixels_read(node->op, {y, y + 1}, int64_t(rows_[input].size()));
          for (int64_t i = rows.begin; i < rows.end; ++i) include(rows_[input][size_t(i)], columns);
        }
      }
}

int64_t Demand::bytes() const {
  int64_t rows = 0;
  for (const std::vector<Span>& of_value : rows_) rows += int64_t(of_value.size());
  return rows * int64_t(sizeof(Span));
}

}  // namespace ld
