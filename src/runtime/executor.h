// Runs the graph of a network on frames. Free of LibTorch.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "frame/sample_arrays.h"
#include "graph/graph.h"
#include "runtime/frame_state.h"
#include "runtime/row_schedule.h"
#include "runtime/row_window.h"
#include "runtime/skipped.h"
#include "weights/named_weights.h"

namespace ld {

/// Nothing here but skip_within above 0 changes a bit of the result.
struct ExecutionOptions {
  int threads = 1;
  int64_t block_rows = 0;  // rows of full resolution that are made at a time; 0: as suits the threads
  /// Work whose result is known is left out: samples that are the pixel's first again, layers without
  /// influence, and the network where the light is so even that its result x differs by at most `skip_within`
  /// (1 + |x|) from what is known beforehand (runtime/light_ranges.h). 0: only what is the same bit for bit.
  /// Nothing: no work is left out.
  std::optional<double> skip_within = {};
  /// Called whenever rows [begin, end) of a value were made, which lie in its window; not for values that
  /// pixelwise operators leave to one another (runtime/unit.h). May be empty.
  std::function<void(graph::ValueId value, const RowWindow& rows, int64_t begin, int64_t end)> made = {};
};

/// The plan of a graph for frames of one size: the order of its steps and one arena for all of their rows.
/// Graph and weights must outlive it. Not for several threads at once.
class Execution {
 public:
  Execution(const graph::Graph& graph, const NamedWeights& weights, const PictureExtent& picture,
            const ExecutionOptions& options = {});
  ~Execution();

  const PictureExtent& picture() const;
  int64_t block_rows() const;

  /// Called in the calling thread with the share of the work that is done, some dozens of times a frame, the
  /// last time with 1; may throw to end it, which leaves nothing behind.
  using Progress = std::function<void(double)>;
  /// Rows [begin, end) of all outputs are there: row(output, plane, y).
  using Rows = std::function<void(int64_t begin, int64_t end)>;

  /// All outputs of the graph (Graph::outputs()), the denoised picture [3 + parts, H, W] first, and behind
  /// them what the frame leaves. The frame has that size and those parts, has been sanitised and has a depth
  /// scale. `before`: what the frame before has left, or nothing. Throws Error for a state of another network
  /// or size.
  std::vector<Image> run(const Frame& frame, const Progress& progress = {}, const FrameState& before = {});
  /// The same, without keeping what `rows` does not keep. `after`, where it is given, receives what the frame
  /// leaves.
  void run(const Frame& frame, const Progress& progress, const Rows& rows, const FrameState& before = {},
           FrameState* after = nullptr);
  /// Of samples that nobody has sanitised, with the bits of a frame of them.
  void run(const SampleArrays& arrays, const Progress& progress, const Rows& rows,
           const FrameState& before = {}, FrameState* after = nullptr);
  /// Of the outputs' rows that are there: number `output`, the graph's own first.
  const float* row(size_t output, int64_t plane, int64_t y) const;

  /// What each node of the graph took in the last run.
  const std::vector<double>& seconds() const;
  /// What the last run has left out.
  Skipped skipped() const;

  /// All rows of all values that exist at a time.
  int64_t arena_bytes() const;
  /// The most that the plan takes while it runs: the arena, weights, and what steps need besides.
  int64_t memory_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ld
