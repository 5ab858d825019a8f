// The embeddings of all samples: the largest thing that a network makes ([MH20] section 3.1).
#pragma once

#include <memory>

#include "models/row_strips.h"
#include "models/sample_reducer.h"
#include "ops/weighted_sum.h"

namespace ld {

/// E_xys of the given features. Where a gradient is kept they are computed once; otherwise on demand, strip
/// by strip (2 GB for 1920x1080 at 8 spp), because the reducer costs less than the memory.
class SampleEmbeddings {
 public:
  SampleEmbeddings(const SampleReducer& reducer, torch::Tensor features)
      : reducer_(reducer), features_(std::move(features)) {
    if (at::GradMode::is_enabled()) all_ = reducer_.forward(features_);
  }

  /// [B, S, E, end - begin, W].
  torch::Tensor of_rows(int64_t begin, int64_t end) const {
    return all_.defined() ? rows(all_, begin, end) : reducer_.forward(rows(features_, begin, end));
  }

  int64_t height() const { return features_.size(3); }

  /// Memory of a row of embeddings, features and `further` channels a sample.
  int64_t row_bytes(int64_t further = 0) const {
    const int64_t outputs = reducer_.weights().weights.back().size(0);
    return features_.size(0) * features_.size(1) * (features_.size(2) + outputs + further) *
           features_.size(4) * int64_t(features_.element_size());
  }

  /// Mean over the valid samples of each pixel, [B, E, H, W]; 0 where there is none.
  torch::Tensor mean(const torch::Tensor& valid) const {
    return in_strips(height(), short_strip_rows(height(), row_bytes()), [&](int64_t begin, int64_t end) {
      return std::vector<torch::Tensor>{masked_mean(of_rows(begin, end), rows(valid, begin, end))};
    })[0];
  }

 private:
  const SampleReducer& reducer_;
  torch::Tensor features_, all_;
};

}  // namespace ld
