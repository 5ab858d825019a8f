// Filtering of layers by splatting: [MH20] eq. 3 and 4 with the kernel weights of appendix A line 26,
// evaluated in the limit of its eps to 0.
#pragma once

#include <torch/torch.h>

namespace ld {

/// Each pixel p scatters its values with a kernel of K x K taps. Tap i*K + j of pixel (y, x) reaches pixel
/// (y + i - r, x + j - r), r = (K-1)/2; taps that leave the picture are lost. With
///   e_l(p,q) = logit_l(p,q) - m_p,  m_p the largest logit of p over all taps and layers,
/// the result at pixel q of layer l is the mean of the values of all p in reach, weighted by n_l(p)
/// exp(e_l(p,q)):
///   out_l(q) = sum_p n_l exp(e_l) v_l / sum_p n_l exp(e_l).
/// For v = L_l/n_l that is filtered L_l over filtered n_l (eq. 4); for v = n_(l+1)/n_l it is 1 - alpha_l. The
/// weights are a softmax at the destination over e_l + log n_l, so neither large logits nor an empty layer
/// lose energy, and values up to the largest float do not overflow.
///
/// logits [B, N, K*K, H, W] (beyond a quarter of the type's range they count as that, NaN as the lowest),
/// log_n [B, N, H, W] (-inf: sends nothing), values [B, N, C, H, W], result [B, N, C, H, W], 0 where nothing
/// arrives. A pixel whose log_n or values are NaN or infinite sends nothing in that layer. All of one
/// floating type. Differentiable in all three; the gradient flows through m_p (at ties, to the first of the
/// largest taps). The bits do not depend on the thread count. Throws Error on shapes that do not fit.
torch::Tensor kernel_splat(const torch::Tensor& logits, const torch::Tensor& log_n,
                           const torch::Tensor& values);

/// The same with one mean over all layers instead of one for each, result [B, C, H, W]:
///   out(q) = sum_l sum_p n_l exp(e_l) v_l / sum_l sum_p n_l exp(e_l).
/// With n = w_l and v = L_l/w_l it is the weighted compositor, eq. 6; with a layer for each sample, n = 1 and
/// v = L_s the SampleSplat network.
torch::Tensor kernel_splat_joint(const torch::Tensor& logits, const torch::Tensor& log_n,
                                 const torch::Tensor& values);

}  // namespace ld
