#include "models/super_resolution.h"

namespace ld {

using torch::Tensor;

Tensor space_to_depth(const Tensor& x) {
  const int64_t below = x.size(2) % 2, right = x.size(3) % 2;
  const Tensor even = below + right > 0 ? at::replication_pad2d(x, {0, right, 0, below}) : x;
  const int64_t b = even.size(0), c = even.size(1), h = even.size(2) / 2, w = even.size(3) / 2;
  return even.reshape({b, c, h, 2, w, 2}).permute({0, 1, 3, 5, 2, 4}).reshape({b, 4 * c, h, w});
}

Tensor depth_to_space(const Tensor& x) {
  const int64_t b = x.size(0), c = x.size(1) / 4, h = x.size(2), w = x.size(3);
  return x.reshape({b, c, 2, 2, h, w}).permute({0, 1, 4, 2, 5, 3}).reshape({b, c, 2 * h, 2 * w});
}

SuperResolution::SuperResolution(int64_t inputs, const SuperResolutionConfig& config)
    : tanh_(config.activation == "tanh") {
  std::vector<int64_t> widths = config.convolutions;
  widths.push_back(12);
  for (const int64_t width : widths) {
    const size_t i = convolutions_.size();
    convolutions_.push_back(
        register_module(std::to_string(i), std::make_shared<EdgeConvolution>(inputs, width, i == 0 ? 5 : 3)));
    inputs = width;
  }
}

Tensor SuperResolution::forward(const Tensor& x) {
  Tensor a = x;
  for (size_t i = 0; i + 1 < convolutions_.size(); ++i) {
    a = convolutions_[i]->forward(a);
    a = tanh_ ? at::tanh(a) : at::relu(a);
  }
  return depth_to_space(convolutions_.back()->forward(a));
}

void SuperResolution::begin_without_checkerboard() {
  const torch::NoGradGuard no_gradient;
  Tensor weight = convolutions_.back()->weight();
  for (int64_t c = 0; c < 3; ++c)
    for (int64_t i = 1; i < 4; ++i) weight.select(0, 4 * c + i).copy_(weight.select(0, 4 * c));
}

}  // namespace ld
