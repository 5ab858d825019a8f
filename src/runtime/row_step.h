// Steps of which each row is made by itself.
#pragma once

#include <utility>

#include "runtime/parallel.h"
#include "runtime/step.h"

namespace ld {

/// Makes row y by row(y, scratch), in a thread's own memory, where anybody reads some of it.
template <class Row>
class RowStep : public Step {
 public:
  RowStep(StepContext& context, const graph::Node& node, int64_t scratch, Row row)
      : context_(context),
        node_(node),
        row_(std::move(row)),
        scratch_(size_t(context.threads), std::vector<float>(size_t(scratch))) {}
  void run(int64_t begin, int64_t end) override {
    const int64_t width = context_.output(node_).width;
    parallel_for(context_.threads, end - begin, [&](int64_t i, int thread) {
      if (context_.demand.wants(node_, begin + i, 0, width)) row_(begin + i, scratch_[size_t(thread)].data());
    });
  }

 private:
  StepContext& context_;
  const graph::Node& node_;
  Row row_;
  std::vector<std::vector<float>> scratch_;
};

/// `scratch`: how many floats a row needs.
template <class Row>
std::unique_ptr<Step> row_step(StepContext& context, const graph::Node& node, int64_t scratch, Row row) {
  return std::make_unique<RowStep<Row>>(context, node, scratch, std::move(row));
}

}  // namespace ld
