#include "runtime/tile_unit.h"

#include <algorithm>
#include <chrono>
#include <type_traits>
#include <utility>
#include <variant>

#include "runtime/parallel.h"

namespace ld {
namespace {

using Clock = std::chrono::steady_clock;

std::unique_ptr<TileStep> make_tile_step(const graph::Node& node, StepContext& context) {
  return std::visit(
      [&](const auto& op) -> std::unique_ptr<TileStep> {
        using Made = decltype(make_step(op, node, context));
        if constexpr (std::is_same_v<Made, std::unique_ptr<TileStep>>) return make_step(op, node, context);
        return nullptr;  // not pixelwise: in no such unit
      },
      node.op);
}

}  // namespace

int64_t tile_pixels(const graph::Graph& graph, const Unit& unit, const PictureExtent& picture) {
  constexpr int64_t kCache = int64_t(320) << 10, kPanel = 48;
  int64_t planes = 0;
  const auto add = [&](graph::ValueId id) { planes += extent_of(graph, id, picture).planes; };
  std::for_each(unit.inputs.begin(), unit.inputs.end(), add);
  for (const size_t n : unit.nodes)
    std::for_each(graph.nodes[n].outputs.begin(), graph.nodes[n].outputs.end(), add);
  const int64_t pixels = kCache / (std::max<int64_t>(planes, 1) * int64_t(sizeof(float)));
  return std::clamp(pixels / kPanel * kPanel, kPanel, kTilePixels);
}

TileUnit::TileUnit(const Unit& unit, StepContext& context)
    : context_(context),
      nodes_(unit.nodes),
      width_(context.windows[unit.outputs[0]].width),
      pixels_(tile_pixels(context.graph, unit, context.picture)),
      seconds_(size_t(context.threads), std::vector<double>(unit.nodes.size(), 0.0)) {
  for (const size_t n : nodes_) steps_.push_back(make_tile_step(context.graph.nodes[n], context));
}

void TileUnit::run(int64_t begin, int64_t end) {
  for_each_stretch(context_.threads, begin, end, width_, pixels_,
                   [&](int64_t y, int64_t x, int64_t count, int thread) {
                     std::vector<double>& seconds = seconds_[size_t(thread)];
                     auto before = Clock::now();
                     for (size_t i = 0; i < steps_.size(); ++i) {
                       if (!context_.demand.wants(context_.graph.nodes[nodes_[i]], y, x, count)) continue;
                       steps_[i]->make({y, x, count, thread});
                       const auto now = Clock::now();
                       seconds[i] += std::chrono::duration<double>(now - before).count();
                       before = now;
                     }
                   });
  for (std::vector<double>& of_thread : seconds_)
    for (size_t i = 0; i < nodes_.size(); ++i)
      context_.seconds[nodes_[i]] += std::exchange(of_thread[i], 0.0) / context_.threads;
}

}  // namespace ld
