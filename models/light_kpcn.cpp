#include "models/light_kpcn.h"

#include "models/kernel_generator.h"
#include "ops/kernel_gather.h"

namespace ld {

using torch::Tensor;

LightKpcn::LightKpcn(int64_t guides, int64_t width, int64_t kernel, double logit_bound)
    : first_(register_module("0", std::make_shared<EdgeConvolution>(3 + guides, width, 3))),
      second_(register_module("1", std::make_shared<EdgeConvolution>(width, width, 3))),
      last_(register_module("2", std::make_shared<EdgeConvolution>(width, kernel * kernel, 3))),
      kernel_(kernel),
      bound_(logit_bound) {}

Tensor LightKpcn::logits(const Tensor& colours, const Tensor& guides) {
  const Tensor a = at::relu(first_->forward(at::cat({colours, guides}, 1)));
  const Tensor b = at::relu(second_->forward(a));
  const Tensor z = last_->forward(a + b);
  return bound_ > 0 ? z * (bound_ / (bound_ + z.abs())) : z;
}

Tensor LightKpcn::forward(const Tensor& colours, const Tensor& guides, const Tensor& log_n) {
  return kernel_gather(logits(colours, guides), log_n, colours);
}

void LightKpcn::begin_as_gaussian(double sigma) {
  const torch::NoGradGuard no_gradient;
  last_->bias().copy_(torch::tensor(gaussian_logits(kernel_, sigma, bound_), torch::kFloat64));
}

}  // namespace ld
