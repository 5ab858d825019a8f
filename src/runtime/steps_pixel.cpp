// What happens to the items of a pixel by itself: fully connected networks and the partition.
#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "models/network_numbers.h"
#include "ops/kernels/partition_tile.h"
#include "ops/kernels/sample_tile.h"
#include "runtime/fully_connected_rows.h"
#include "runtime/tile_step.h"

namespace ld {
namespace {

class FullyConnectedStep : public TileStep {
 public:
  FullyConnectedStep(const graph::FullyConnected& op, const graph::Node& node, StepContext& context)
      : context_(context),
        x_(context.input(node, 0)),
        out_(context.output(node)),
        items_(context.items(node.outputs[0])),
        network_(tile_network(op, context.weights, context.graph[node.inputs[0]].channels,
                              context.graph[node.outputs[0]].channels)),
        scratch_(network_.make_scratches(context.threads, kTilePixels)) {
    if (node.inputs.size() > 1) shared_ = context.input(node, 1);
  }

  void make(const PixelTile& tile) override {
    TileNetwork::Scratch& scratch = scratch_[size_t(tile.thread)];
    if (shared_) network_.begin_tile(scratch, tile.count, shared_->at(tile));
    for (int64_t item = 0; item < items_; ++item)
      if (context_.skips && item > 0 && is_first_again(tile, item))
        copy_first(tile, item);
      else
        network_.forward(scratch, tile.count, x_.at(tile, item * network_.x_inputs()),
                         out_.at(tile, item * network_.outputs()));
  }

 private:
  /// Whether a pixel's item is its first, bit for bit, in the whole tile.
  bool is_first_again(const PixelTile& tile, int64_t item) const {
    const PlanarRow first = x_.at(tile), other = x_.at(tile, item * network_.x_inputs());
    for (int64_t c = 0; c < network_.x_inputs(); ++c)
      if (std::memcmp(first.plane(c), other.plane(c), size_t(tile.count) * sizeof(float)) != 0) return false;
    return true;
  }

  void copy_first(const PixelTile& tile, int64_t item) const {
    const PlanarTarget first = out_.at(tile), other = out_.at(tile, item * network_.outputs());
    for (int64_t c = 0; c < network_.outputs(); ++c)
      std::copy_n(first.plane(c), padded(tile.count), other.plane(c));
    context_.copied[size_t(tile.thread)] += tile.count;
  }

  StepContext& context_;
  RowWindow x_, out_;
  std::optional<RowWindow> shared_;
  int64_t items_;
  TileNetwork network_;
  std::vector<TileNetwork::Scratch> scratch_;  // of each thread
};

class PartitionStep : public TileStep {
 public:
  PartitionStep(const graph::Partition& op, const graph::Node& node, StepContext& context) {
    for (size_t i = 0; i < node.inputs.size(); ++i) inputs_.push_back(context.input(node, i));
    for (size_t i = 0; i < node.outputs.size(); ++i) outputs_.push_back(context.output(node, i));
    const int64_t samples = context.items(node.inputs[0]);
    shape_ = {samples, inputs_[0].planes / samples, inputs_[2].planes / samples, inputs_[3].planes / samples,
              op.alpha};
    for (int t = 0; t < context.threads; ++t) scratch_.emplace_back(shape_);
  }

  void make(const PixelTile& tile) override {
    for (int64_t x = 0; x < tile.count; x += kPartitionPixels) {
      const auto in = [&](size_t i) {
        const PlanarRow rows = inputs_[i].at(tile);
        return PlanarRow{rows.data + x, rows.pitch};
      };
      const auto out = [&](size_t i) {
        const PlanarTarget rows = outputs_[i].at(tile);
        return PlanarTarget{rows.data + x, rows.pitch};
      };
      partition_tile(shape_, {in(0), in(1), in(2), in(3)},
                     {out(0), out(1), out(2), shape_.alpha ? out(4) : PlanarTarget(), out(3)},
                     std::min(kPartitionPixels, tile.count - x), scratch_[size_t(tile.thread)]);
    }
  }

 private:
  std::vector<RowWindow> inputs_, outputs_;
  PartitionShape shape_{};
  std::vector<PartitionScratch> scratch_;
};

class RejectStep : public TileStep {
 public:
  RejectStep(const graph::Reject& op, const graph::Node& node, StepContext& context)
      : log_n_(context.input(node, 0)),
        embedding_(context.input(node, 1)),
        shared_(context.input(node, 2)),
        out_(context.output(node)),
        network_(tile_network({op.weights, {1}}, context.weights, embedding_.planes / out_.planes, 1)),
        scratch_(network_.make_scratches(context.threads, kTilePixels)) {}

  void make(const PixelTile& tile) override {
    TileNetwork::Scratch& scratch = scratch_[size_t(tile.thread)];
    network_.begin_tile(scratch, tile.count, shared_.at(tile));
    for (int64_t item = 0; item < out_.planes; ++item) {
      const PlanarTarget to = out_.at(tile, item);
      network_.forward(scratch, tile.count, embedding_.at(tile, item * network_.x_inputs()), to);
      reject(log_n_.at(tile, item).data, to.data, float(kMostRejected), padded(tile.count), to.data);
    }
  }

 private:
  RowWindow log_n_, embedding_, shared_, out_;
  TileNetwork network_;
  std::vector<TileNetwork::Scratch> scratch_;  // of each thread
};

}  // namespace

std::unique_ptr<TileStep> make_step(const graph::LayerIdentity&, const graph::Node& node,
                                    StepContext& context) {
  const RowWindow out = context.output(node);  // zeros from the first on
  const auto layers = int64_t(std::lround(std::sqrt(double(out.planes))));
  return tile_step(context, 0, [=](const PixelTile& tile, float*) {
    for (int64_t l = 0; l < layers; ++l) std::fill_n(out.at(tile, l * layers + l).data, tile.count, 1.0f);
  });
}
std::unique_ptr<TileStep> make_step(const graph::FullyConnected& op, const graph::Node& node,
                                    StepContext& context) {
  return std::make_unique<FullyConnectedStep>(op, node, context);
}
std::unique_ptr<TileStep> make_step(const graph::Partition& op, const graph::Node& node,
                                    StepContext& context) {
  return std::make_unique<PartitionStep>(op, node, context);
}
std::unique_ptr<TileStep> make_step(const graph::Reject& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<RejectStep>(op, node, context);
}

}  // namespace ld
