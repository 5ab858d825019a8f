// Kernels that weigh what a pixel receives.
#include <algorithm>
#include <cmath>
#include <limits>

#include "ops/kernels/gather.h"
#include "runtime/fully_connected_rows.h"
#include "runtime/parallel.h"
#include "runtime/step.h"

namespace ld {
namespace {

/// What gathers share: sources in rows, and a stretch at a time of the results.
class GatheringStep : public Step {
 public:
  GatheringStep(StepContext& context, const graph::Node& node, int64_t kernel, const RowWindow& log_n,
                graph::ValueId values)
      : node_(node),
        context_(context),
        log_n_(log_n),
        values_(context.windows[values]),
        out_(context.output(node)),
        main_(context.graph[values].channels - context.graph[values].parts),
        shape_{1, kernel, values_.planes, values_.height, values_.width},
        pixels_(stretch_pixels(shape_.taps(), shape_.width)),
        sources_(shape_, values_.capacity),
        finite_values_(values_.planes, values_.width, 1, 1),
        memory_(hwy::AllocateAligned<float>(size_t(finite_values_.floats()))),
        finite_log_n_(size_t(values_.width)) {
    finite_values_.memory = memory_.get();
    for (int t = 0; t < context.threads; ++t) rows_.emplace_back(shape_, pixels_);
  }

  void start() override { filled_ = 0; }
  int64_t scratch_bytes(int64_t) const override { return sources_.floats() * int64_t(sizeof(float)); }

  void run(int64_t begin, int64_t end) override {
    for (const int64_t last = std::min(end + shape_.radius(), shape_.height); filled_ < last; ++filled_)
      fill(filled_);
    for_each_stretch(context_.threads, begin, end, shape_.width, pixels_,
                     [&](int64_t y, int64_t x, int64_t count, int thread) {
                       if (!context_.demand.wants(node_, y, x, count)) return;
                       GatherRow& row = rows_[size_t(thread)];
                       make_logits({y, x, count}, thread, row.logits);
                       gather_stretch(shape_, sources_, {y, x, count}, row);
                       for (int64_t c = 0; c < shape_.channels; ++c) {
                         const float* from = row.out.row(c);
                         float* to = out_.row(y, c) + x;
                         const float scale = scale_of(c);
                         for (int64_t i = 0; i < count; ++i) to[i] = from[i] / scale;
                       }
                     });
  }

 protected:
  /// The logits of all taps of a stretch.
  virtual void make_logits(const Stretch& at, int thread, StagedRows& logits) = 0;

  int64_t pixels() const { return pixels_; }

 private:
  float scale_of(int64_t channel) const {
    return channel < main_ ? context_.source->light.value_scale : context_.source->light.part_scale;
  }

  /// Row y of the sources; a pixel whose values or weight are not finite gives nothing
  /// (ops/finite_sources.h). Parts have no say in that: they are finite.
  void fill(int64_t y) {
    for (int64_t x = 0; x < shape_.width; ++x) {
      bool good = log_n_.row(y)[x] < std::numeric_limits<float>::infinity();
      for (int64_t c = 0; c < shape_.channels; ++c)
        good = good && std::fabs(values_.row(y, c)[x]) <= std::numeric_limits<float>::max();
      finite_log_n_[size_t(x)] = good ? log_n_.row(y)[x] : -std::numeric_limits<float>::infinity();
      for (int64_t c = 0; c < shape_.channels; ++c)
        finite_values_.row(0, c)[x] = good ? values_.row(y, c)[x] * scale_of(c) : 0.0f;
    }
    sources_.fill_row(shape_, {finite_log_n_.data(), 0}, finite_values_.planar(0), y);
  }

  const graph::Node& node_;
  StepContext& context_;
  RowWindow log_n_, values_, out_;
  int64_t main_;  // channels before those of parts
  FilterShape shape_;
  int64_t pixels_;
  GatherSources sources_;
  RowWindow finite_values_;  // of a row on its way to the sources
  Floats memory_;
  std::vector<float> finite_log_n_;
  std::vector<GatherRow> rows_;  // of each thread
  int64_t filled_ = 0;
};

class GatherStep : public GatheringStep {
 public:
  GatherStep(const graph::Gather& op, const graph::Node& node, StepContext& context)
      : GatheringStep(context, node, op.kernel, context.input(node, 2), node.inputs[3]),
        embedding_(context.input(node, 0)),
        shared_(context.input(node, 1)),
        network_(tile_network(op.generator, context.weights, embedding_.planes, op.kernel * op.kernel)) {
    for (int t = 0; t < context.threads; ++t) scratch_.push_back(network_.make_scratch(pixels(), false));
  }

 private:
  void make_logits(const Stretch& at, int thread, StagedRows& logits) override {
    TileNetwork::Scratch& scratch = scratch_[size_t(thread)];
    network_.begin_tile(scratch, at.count, {shared_.row(at.y) + at.x, shared_.pitch});
    network_.forward(scratch, at.count, {embedding_.row(at.y) + at.x, embedding_.pitch},
                     {logits.row(0), logits.pitch()});
  }

  RowWindow embedding_, shared_;
  TileNetwork network_;
  std::vector<TileNetwork::Scratch> scratch_;
};

class GatherTapsStep : public GatheringStep {
 public:
  GatherTapsStep(const graph::GatherTaps& op, const graph::Node& node, StepContext& context)
      : GatheringStep(context, node, op.kernel, context.input(node, 1), node.inputs[2]),
        taps_(context.input(node, 0)),
        bound_(float(op.bound)) {}

 private:
  void make_logits(const Stretch& at, int /*thread*/, StagedRows& logits) override {
    for (int64_t tap = 0; tap < taps_.planes; ++tap) {
      const float* from = taps_.row(at.y, tap) + at.x;
      float* to = logits.row(tap);
      for (int64_t i = 0; i < at.count; ++i)
        to[i] = bound_ > 0 ? from[i] * (bound_ / (bound_ + std::fabs(from[i]))) : from[i];
    }
  }

  RowWindow taps_;
  float bound_;
};

class BlurStep : public GatheringStep {
 public:
  BlurStep(const graph::Blur& op, const graph::Node& node, StepContext& context)
      : GatheringStep(context, node, op.kernel, context.input(node, 0), node.inputs[1]) {
    for (const double logit : op.logits()) logits_.push_back(float(logit));
  }

 private:
  void make_logits(const Stretch& at, int /*thread*/, StagedRows& logits) override {
    for (size_t tap = 0; tap < logits_.size(); ++tap)
      std::fill_n(logits.row(int64_t(tap)), padded(at.count), logits_[tap]);
  }

  std::vector<float> logits_;  // of each tap
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::Gather& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<GatherStep>(op, node, context);
}
std::unique_ptr<Step> make_step(const graph::GatherTaps& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<GatherTapsStep>(op, node, context);
}
std::unique_ptr<Step> make_step(const graph::Blur& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<BlurStep>(op, node, context);
}

}  // namespace ld
