// The operators as compositions of LibTorch's own: what doubles and other devices than the CPU take, what the
// SIMD kernels are tested with, and the baseline of ld_bench. The same maths, so the same stable formulation;
// the arguments have been checked by the operators that hand over here.
#pragma once

#include <torch/torch.h>

#include <optional>

#include "core/scoped_value.h"
#include "ops/fully_connected.h"
#include "ops/partition.h"

namespace ld {

/// How a composition takes the K*K taps of the logits apart: all at once, or with a slice for each. The slice
/// is how the code published with [MH20] is written; on the way back each has a gradient the size of all
/// logits, which makes a training step five times slower.
enum class Taps { at_once, sliced };

/// While one lives, the operators of this thread run as compositions, also for float32 on the CPU, and
/// tensors come from LibTorch's own allocator (ops/memory_pool.h).
class ComposedOperators : public ScopedValue<ComposedOperators, std::optional<Taps>> {
 public:
  explicit ComposedOperators(Taps taps = Taps::at_once) : ScopedValue(taps) {}
};

/// Whether one lives in this thread.
inline bool composed_operators() {
  return ComposedOperators::current().has_value();
}

/// Whether an operator on `tensor` is to run as a composition: doubles, other devices, ComposedOperators.
bool runs_composed(const torch::Tensor& tensor);

/// Contracts: ops/fully_connected.h, ops/kernel_splat.h, ops/kernel_gather.h, ops/partition.h.
namespace composed {

/// As [MH20] appendix B realises it: 1x1 convolutions over [x, shared].
torch::Tensor fully_connected(const torch::Tensor& x, const torch::Tensor& shared,
                              const FullyConnectedWeights& network, bool activate_last);

/// One shifted multiply-add of the whole picture for each of the K*K taps.
torch::Tensor kernel_splat(const torch::Tensor& logits, const torch::Tensor& log_n,
                           const torch::Tensor& values, bool joint);
torch::Tensor kernel_gather(const torch::Tensor& logits, const torch::Tensor& log_n,
                            const torch::Tensor& values);

Partition partition(const torch::Tensor& logits, const torch::Tensor& valid, const torch::Tensor& radiance,
                    const torch::Tensor& embedding, Compositing compositing);

}  // namespace composed
}  // namespace ld
