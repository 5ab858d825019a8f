// What happens to the items of a pixel by itself: fully connected networks and the partition.
#include <algorithm>
#include <cmath>
#include <optional>

#include "models/network_numbers.h"
#include "ops/kernels/partition_tile.h"
#include "runtime/fully_connected_rows.h"
#include "runtime/row_step.h"

namespace ld {
namespace {

constexpr int64_t kTilePixels = 192;  // whole panels of every vector width

class FullyConnectedStep : public Step {
 public:
  FullyConnectedStep(const graph::FullyConnected& op, const graph::Node& node, StepContext& context)
      : context_(context),
        x_(context.input(node, 0)),
        out_(context.output(node)),
        items_(context.items(node.outputs[0])),
        network_(tile_network(op, context.weights, context.graph[node.inputs[0]].channels,
                              context.graph[node.outputs[0]].channels)) {
    if (node.inputs.size() > 1) shared_ = context.input(node, 1);
    for (int t = 0; t < context.threads; ++t) scratch_.push_back(network_.make_scratch(kTilePixels, false));
  }

  void run(int64_t begin, int64_t end) override {
    const int64_t inputs = network_.x_inputs(), outputs = network_.outputs();
    for_each_stretch(context_.threads, begin, end, out_.width, kTilePixels,
                     [&](int64_t y, int64_t x, int64_t count, int thread) {
                       TileNetwork::Scratch& scratch = scratch_[size_t(thread)];
                       if (shared_)
                         network_.begin_tile(scratch, count, {shared_->row(y) + x, shared_->pitch});
                       for (int64_t item = 0; item < items_; ++item)
                         network_.forward(scratch, count, {x_.row(y, item * inputs) + x, x_.pitch},
                                          out_.row(y, item * outputs) + x, out_.pitch);
                     });
  }

 private:
  StepContext& context_;
  RowWindow x_, out_;
  std::optional<RowWindow> shared_;
  int64_t items_;
  TileNetwork network_;
  std::vector<TileNetwork::Scratch> scratch_;
};

class PartitionStep : public Step {
 public:
  PartitionStep(const graph::Partition& op, const graph::Node& node, StepContext& context)
      : context_(context) {
    for (size_t i = 0; i < node.inputs.size(); ++i) inputs_.push_back(context.input(node, i));
    for (size_t i = 0; i < node.outputs.size(); ++i) outputs_.push_back(context.output(node, i));
    const int64_t samples = context.items(node.inputs[0]);
    shape_ = {samples,
              inputs_[0].planes / samples,
              inputs_[2].planes / samples,
              inputs_[3].planes / samples,
              inputs_[0].pitch,
              op.alpha};
    for (int t = 0; t < context.threads; ++t) scratch_.emplace_back(shape_);
  }

  void run(int64_t begin, int64_t end) override {
    for_each_stretch(context_.threads, begin, end, inputs_[0].width, kPartitionPixels,
                     [&](int64_t y, int64_t x, int64_t count, int thread) {
                       const auto in = [&](size_t i) { return inputs_[i].row(y); };
                       const auto out = [&](size_t i) { return outputs_[i].row(y); };
                       partition_tile(shape_, {in(0), in(1), in(2), in(3)},
                                      {out(0), out(1), out(2), shape_.alpha ? out(4) : nullptr, out(3)}, x,
                                      count, scratch_[size_t(thread)]);
                     });
  }

 private:
  StepContext& context_;
  std::vector<RowWindow> inputs_, outputs_;
  PartitionShape shape_{};
  std::vector<PartitionScratch> scratch_;
};

class LayerIdentityStep : public Step {
 public:
  explicit LayerIdentityStep(const RowWindow& out) : out_(out) {}

  void run(int64_t begin, int64_t end) override {
    const auto layers = int64_t(std::lround(std::sqrt(double(out_.planes))));
    for (int64_t y = begin; y < end; ++y)
      for (int64_t l = 0; l < layers; ++l) std::fill_n(out_.row(y, l * layers + l), out_.width, 1.0f);
  }

 private:
  RowWindow out_;  // zeros from the first on
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::LayerIdentity&, const graph::Node& node, StepContext& context) {
  return std::make_unique<LayerIdentityStep>(context.output(node));
}
std::unique_ptr<Step> make_step(const graph::FullyConnected& op, const graph::Node& node,
                                StepContext& context) {
  return std::make_unique<FullyConnectedStep>(op, node, context);
}
std::unique_ptr<Step> make_step(const graph::Partition& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<PartitionStep>(op, node, context);
}
std::unique_ptr<Step> make_step(const graph::Reject& op, const graph::Node& node, StepContext& context) {
  const RowWindow log_n = context.input(node, 0), embedding = context.input(node, 1),
                  shared = context.input(node, 2), out = context.output(node);
  const int64_t channels = embedding.planes / out.planes;
  return row_step(context, 0, [=, weights = one_output(op.weights, context.weights)](int64_t y, float*) {
    for (int64_t item = 0; item < out.planes; ++item) {
      float* __restrict to = out.row(y, item);
      std::fill_n(to, out.width, weights[0]);
      for (int64_t c = 0; c < channels; ++c)
        add_weighted(embedding.row(y, item * channels + c), weights[size_t(1 + c)], out.width, to);
      for (int64_t c = 0; c < shared.planes; ++c)
        add_weighted(shared.row(y, c), weights[size_t(1 + channels + c)], out.width, to);
      const float* __restrict from = log_n.row(y, item);
      for (int64_t x = 0; x < out.width; ++x) to[x] = from[x] - float(kMostRejected) / (1 + std::exp(-to[x]));
    }
  });
}

}  // namespace ld
