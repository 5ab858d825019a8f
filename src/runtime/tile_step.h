// Pixelwise operators at work (graph/operators.h), tile by tile.
#pragma once

#include <utility>

#include "runtime/step.h"

namespace ld {

/// Makes tile by body(tile, scratch), in a thread's own memory.
template <class Body>
class BodyTileStep : public TileStep {
 public:
  BodyTileStep(StepContext& context, int64_t scratch, Body body)
      : body_(std::move(body)),
        floats_(padded(scratch)),
        scratch_(hwy::AllocateAligned<float>(size_t(std::max<int64_t>(floats_, 1) * context.threads))) {}
  void make(const PixelTile& tile) override { body_(tile, scratch_.get() + tile.thread * floats_); }

 private:
  Body body_;
  int64_t floats_;
  Floats scratch_;
};

/// `scratch`: how many floats a tile needs.
template <class Body>
std::unique_ptr<TileStep> tile_step(StepContext& context, int64_t scratch, Body body) {
  return std::make_unique<BodyTileStep<Body>>(context, scratch, std::move(body));
}

}  // namespace ld
