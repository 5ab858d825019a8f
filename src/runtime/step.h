// An operator of a graph at work: makes rows of its outputs from the rows of its inputs.
#pragma once

#include <memory>
#include <vector>

#include "graph/graph.h"
#include "runtime/demand.h"
#include "runtime/frame_state.h"
#include "runtime/row_schedule.h"
#include "runtime/row_window.h"
#include "runtime/sample_source.h"
#include "weights/named_weights.h"

namespace ld {

class Step {
 public:
  virtual ~Step() = default;
  /// The rows before `begin` are made, those that are read of the inputs are there.
  virtual void run(int64_t begin, int64_t end) = 0;
  /// Before row 0 of a frame.
  virtual void start() {}
  /// What the step needs besides windows and weights when it makes so many rows at a time; nothing that is as
  /// small as a stretch of a row.
  virtual int64_t scratch_bytes(int64_t /*rows*/) const { return 0; }
};

/// A pixelwise operator (graph/operators.h) at work.
class TileStep {
 public:
  virtual ~TileStep() = default;
  /// The same tile of the inputs is there. Writes whole vectors of pixels, up to padded(tile.count).
  virtual void make(const PixelTile& tile) = 0;
};

constexpr int64_t kTilePixels = 192;  // at most, of a tile: whole panels of every vector width

/// What steps work in. It outlives them.
struct StepContext {
  const graph::Graph& graph;
  const NamedWeights& weights;
  PictureExtent picture;
  int threads = 1;
  std::vector<RowWindow> windows;  // of each value

  // Of the frame that runs.
  Demand demand;                           // what is read of each value: steps make nothing else
  bool skips = false;                      // whether work is looked for whose result is known
  std::vector<int64_t> copied = {};        // by each thread: a pixel's items that are its first again
  std::vector<int64_t> empty_layers = {};  // by each thread: pixels of layers without influence
  SampleSource* source = nullptr;
  const FrameState* before = nullptr;  // null at the start of a sequence
  std::vector<double> seconds = {};    // that each node has taken so far

  const RowWindow& input(const graph::Node& node, size_t i) const { return windows[node.inputs[i]]; }
  const RowWindow& output(const graph::Node& node, size_t i = 0) const { return windows[node.outputs[i]]; }
  int64_t items(graph::ValueId id) const { return windows[id].planes / graph[id].channels; }
};

// One for each operator; files by kind: steps_*.cpp.
std::unique_ptr<TileStep> make_step(const graph::Encode& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::MaskedMean& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::AnyValid& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::LogValid& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::FirstValid& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Statistics& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::ToneMapped& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::FullyConnected& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<Step> make_step(const graph::Pad& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::Convolution& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::EdgeConvolution& op, const graph::Node& node,
                                StepContext& context);
std::unique_ptr<Step> make_step(const graph::SpaceToDepth& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::DepthToSpace& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::HalveLight& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Relight& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Channels& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Add& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::GatherTaps& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::MaxPool& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::Upsample& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::Halve& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::Received& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::BlendLevels& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Demodulate& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Reflectance& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Partition& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Reject& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::Splat& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::Gather& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::Blur& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Mix& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Composite& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<Step> make_step(const graph::ModulationFactors& op, const graph::Node& node,
                                StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Modulate& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::Recall& op, const graph::Node& node, StepContext& context);
std::unique_ptr<Step> make_step(const graph::Compare& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::Remember& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::TakeRoots& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::RaiseRoots& op, const graph::Node& node,
                                    StepContext& context);
std::unique_ptr<Step> make_step(const graph::RecallPart& op, const graph::Node& node, StepContext& context);
std::unique_ptr<TileStep> make_step(const graph::LayerIdentity& op, const graph::Node& node,
                                    StepContext& context);

}  // namespace ld
