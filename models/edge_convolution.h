// A convolution of pictures whose border pixels are repeated beyond the border.
#pragma once

#include <torch/torch.h>

namespace ld {

/// kernel x kernel taps, an odd number. Parameters: weight [outputs, inputs, kernel, kernel], bias [outputs],
/// zeros at first.
class EdgeConvolution : public torch::nn::Module {
 public:
  EdgeConvolution(int64_t inputs, int64_t outputs, int64_t kernel)
      : radius_(kernel / 2),
        weight_(register_parameter("weight", torch::zeros({outputs, inputs, kernel, kernel}))),
        bias_(register_parameter("bias", torch::zeros({outputs}))) {}

  torch::Tensor forward(const torch::Tensor& x) {
    return at::conv2d(at::replication_pad2d(x, {radius_, radius_, radius_, radius_}), weight_, bias_);
  }

  torch::Tensor& weight() { return weight_; }
  torch::Tensor& bias() { return bias_; }

 private:
  int64_t radius_;
  torch::Tensor weight_, bias_;
};

}  // namespace ld
