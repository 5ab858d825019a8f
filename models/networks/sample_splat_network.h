// SampleSplat of [MH20] section 5, after Gharbi et al. 2019: a kernel for each sample, network name
// "sample_splat".
#pragma once

#include "models/kernel_generator.h"
#include "models/networks/context_network.h"

namespace ld {

/// Every sample scatters its radiance with a kernel of its own, made from its embedding and the context:
///   o(q) = sum_ps exp(e_s(p,q)) L_s(p) / sum_ps exp(e_s(p,q)),  e_s(p,q) = logit_s(p,q) - m_p,
/// m_p the largest logit of the pixel over taps and valid samples.
class SampleSplatNetwork : public ContextNetwork {
 public:
  explicit SampleSplatNetwork(const NetworkConfig& config);

 private:
  torch::Tensor denoise(const NetworkInput& input, NetworkState& state) override;
  Kernels make_kernels(const NetworkInput& input) override;

  std::shared_ptr<KernelGenerator> kernel_generator_;
};

}  // namespace ld
