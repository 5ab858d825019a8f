// The embeddings of all samples: the largest thing that a network makes ([MH20] section 3.1).
#pragma once

#include <memory>

#include "models/network_input.h"
#include "models/row_strips.h"
#include "models/sample_reducer.h"
#include "ops/weighted_sum.h"

namespace ld {

/// E_xys of an input's features. Where a gradient is kept they are computed once; otherwise on demand, strip
/// by strip (2 GB for 1920x1080 at 8 spp), because the reducer costs less than the memory.
class SampleEmbeddings {
 public:
  SampleEmbeddings(const SampleReducer& reducer, const InputSource& input)
      : reducer_(reducer), input_(input) {
    if (at::GradMode::is_enabled()) all_ = reducer_.forward(input.rows(0, height()).features);
  }

  /// [B, S, E, end - begin, W]; `strip` is input.rows(begin, end).
  torch::Tensor of_rows(const NetworkInput& strip, int64_t begin, int64_t end) const {
    return all_.defined() ? rows(all_, begin, end) : reducer_.forward(strip.features);
  }

  int64_t height() const { return input_.sizes().height; }

  /// Memory of a row of embeddings, input (twice: it may have to be mended) and `further` channels a sample.
  int64_t row_bytes(int64_t further = 0) const {
    const InputSource::Sizes sizes = input_.sizes();
    const auto& weights = reducer_.weights().weights;
    const int64_t channels = 2 * (weights.front().size(1) + 4) + weights.back().size(0) + further;
    return sizes.batch * sizes.samples * channels * sizes.width * sizes.element_bytes;
  }

  /// Mean over the valid samples of each pixel in rows [begin, end), [B, E, end - begin, W]; 0 where there is
  /// none.
  torch::Tensor mean(int64_t begin, int64_t end) const {
    const int64_t step = short_strip_rows(end - begin, row_bytes());
    return in_strips(begin, end, step, [&](int64_t first, int64_t last) {
      const NetworkInput strip = input_.rows(first, last);
      return masked_mean(of_rows(strip, first, last), strip.valid);
    });
  }

 private:
  const SampleReducer& reducer_;
  const InputSource& input_;
  torch::Tensor all_;
};

}  // namespace ld
