// Pixelwise nodes at work together.
#pragma once

#include <memory>
#include <vector>

#include "runtime/step.h"
#include "runtime/unit.h"

namespace ld {

/// Pixels of a unit's tiles: as many as leave what its nodes make and read in the second cache level.
int64_t tile_pixels(const graph::Graph& graph, const Unit& unit, const PictureExtent& picture);

class TileUnit : public Step {
 public:
  TileUnit(const Unit& unit, StepContext& context);
  void run(int64_t begin, int64_t end) override;

 private:
  StepContext& context_;
  std::vector<size_t> nodes_;
  std::vector<std::unique_ptr<TileStep>> steps_;  // of each node
  int64_t width_, pixels_;
  std::vector<std::vector<double>> seconds_;  // of each thread and node, in run()
};

}  // namespace ld
