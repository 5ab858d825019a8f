// Steps of which each row is made by itself.
#pragma once

#include <utility>

#include "runtime/parallel.h"
#include "runtime/step.h"

namespace ld {

/// Makes row y by row(y, scratch), in a thread's own memory.
template <class Row>
class RowStep : public Step {
 public:
  RowStep(StepContext& context, int64_t scratch, Row row)
      : context_(context),
        row_(std::move(row)),
        scratch_(size_t(context.threads), std::vector<float>(size_t(scratch))) {}
  void run(int64_t begin, int64_t end) override {
    parallel_for(context_.threads, end - begin,
                 [&](int64_t i, int thread) { row_(begin + i, scratch_[size_t(thread)].data()); });
  }

 private:
  StepContext& context_;
  Row row_;
  std::vector<std::vector<float>> scratch_;
};

/// `scratch`: how many floats a row needs.
template <class Row>
std::unique_ptr<Step> row_step(StepContext& context, int64_t scratch, Row row) {
  return std::make_unique<RowStep<Row>>(context, scratch, std::move(row));
}

}  // namespace ld
