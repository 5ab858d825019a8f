// Runs the graph of a network on frames. Free of LibTorch.
#pragma once

#include <memory>

#include "frame/frame.h"
#include "graph/graph.h"
#include "runtime/named_weights.h"
#include "runtime/row_schedule.h"

namespace ld {

struct ExecutionOptions {
  int threads = 1;
  int64_t block_rows =
      0;  // rows of full resolution that are made at a time; 0: as suits the threads. Changes no bit.
};

/// The plan of a graph for frames of one size: the order of its steps and one arena for all of their rows.
/// Weights and graph must outlive it.
class Execution {
 public:
  Execution(const graph::Graph& graph, const NamedWeights& weights, const PictureExtent& picture,
            const ExecutionOptions& options = {});
  ~Execution();

  /// The denoised picture [3, H, W] of a frame of that size, which has been sanitised and has a depth scale.
  Image run(const Frame& frame);

  /// Of the arena: all rows of all values that exist at a time.
  int64_t arena_bytes() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace ld
