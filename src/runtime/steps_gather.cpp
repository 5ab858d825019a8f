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

class GatherStep : public Step {
 public:
  GatherStep(const graph::Gather& op, const graph::Node& node, StepContext& context)
      : context_(context),
        embedding_(context.input(node, 0)),
        shared_(context.input(node, 1)),
        log_n_(context.input(node, 2)),
        values_(context.input(node, 3)),
        out_(context.output(node)),
        network_(tile_network(op.generator, context.weights, embedding_.planes, op.kernel * op.kernel)),
        shape_{1, op.kernel, values_.planes, values_.height, values_.width},
        pixels_(stretch_pixels(shape_.taps(), shape_.width)),
        sources_(shape_, values_.capacity),
        finite_values_(values_.planes, values_.width, 1, 1),
        memory_(hwy::AllocateAligned<float>(size_t(finite_values_.floats()))),
        finite_log_n_(size_t(values_.width)) {
    finite_values_.memory = memory_.get();
    for (int t = 0; t < context.threads; ++t)
      workers_.push_back({network_.make_scratch(pixels_, false), GatherRow(shape_, pixels_)});
  }

  void start() override { filled_ = 0; }

  void run(int64_t begin, int64_t end) override {
    for (const int64_t last = std::min(end + shape_.radius(), shape_.height); filled_ < last; ++filled_)
      fill(filled_);
    for_each_stretch(context_.threads, begin, end, shape_.width, pixels_,
                     [&](int64_t y, int64_t x, int64_t count, int thread) {
                       Worker& worker = workers_[size_t(thread)];
                       network_.begin_tile(worker.scratch, count, {shared_.row(y) + x, shared_.pitch});
                       network_.forward(worker.scratch, count, {embedding_.row(y) + x, embedding_.pitch},
                                        worker.row.logits.row(0), worker.row.logits.pitch());
                       gather_stretch(shape_, sources_, {y, x, count}, worker.row);
                       for (int64_t c = 0; c < shape_.channels; ++c) {
                         const float* from = worker.row.out.row(c);
                         float* to = out_.row(y, c) + x;
                         for (int64_t i = 0; i < count; ++i) to[i] = from[i] / context_.value_scale;
                       }
                     });
  }

 private:
  struct Worker {
    TileNetwork::Scratch scratch;
    GatherRow row;
  };

  /// Row y of the sources; a pixel whose values or weight are not finite gives nothing
  /// (ops/finite_sources.h).
  void fill(int64_t y) {
    for (int64_t x = 0; x < shape_.width; ++x) {
      bool good = log_n_.row(y)[x] < std::numeric_limits<float>::infinity();
      for (int64_t c = 0; c < shape_.channels; ++c)
        good = good && std::fabs(values_.row(y, c)[x]) <= std::numeric_limits<float>::max();
      finite_log_n_[size_t(x)] = good ? log_n_.row(y)[x] : -std::numeric_limits<float>::infinity();
      for (int64_t c = 0; c < shape_.channels; ++c)
        finite_values_.row(0, c)[x] = good ? values_.row(y, c)[x] * context_.value_scale : 0.0f;
    }
    sources_.fill_row(shape_, {finite_log_n_.data(), 0}, finite_values_.planar(0), y);
  }

  StepContext& context_;
  RowWindow embedding_, shared_, log_n_, values_, out_;
  TileNetwork network_;
  FilterShape shape_;
  int64_t pixels_;
  GatherSources sources_;
  RowWindow finite_values_;  // of a row on its way to the sources
  Floats memory_;
  std::vector<float> finite_log_n_;
  std::vector<Worker> workers_;
  int64_t filled_ = 0;
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::Gather& op, const graph::Node& node, StepContext& context) {
  return std::make_unique<GatherStep>(op, node, context);
}

}  // namespace ld
