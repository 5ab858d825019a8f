#include "training/kernel_statistics.h"

#include <fmt/format.h>

#include <algorithm>

namespace ld {

using torch::Tensor;

namespace {

/// x log x, 0 at 0.
Tensor x_log_x(const Tensor& x) {
  return x * x.masked_fill(x.eq(0), 1).log();
}

}  // namespace

KernelStatistics kernel_statistics(Network& network, const NetworkInput& input) {
  const torch::NoGradGuard no_graph;
  const Kernels kernels = network.kernels(input);
  const Tensor exponents = kernels.logits + kernels.log_n.unsqueeze(2);  // [B, N, K*K, H, W]
  // In a pixel without samples all exponents are infinite; its shares are NaN, and become 0.
  const Tensor share =
      at::softmax(exponents.flatten(1, 2), 1).nan_to_num(0).view(exponents.sizes()).to(torch::kFloat64);
  const double pixels = share.sum().item<double>();  // how many send something: the shares of each sum to 1
  const Tensor of_layers = share.sum(2);
  const int64_t centre = share.size(2) / 2;
  KernelStatistics statistics;
  if (pixels == 0) return statistics;
  // The entropy of the tap when the layer is known: H(tap, layer) - H(layer), which rounding alone can make
  // negative.
  const double entropy = (x_log_x(of_layers).sum() - x_log_x(share).sum()).item<double>();
  statistics.entropy = std::max(entropy, 0.0) / pixels;
  statistics.centre_share = share.select(2, centre).sum().item<double>() / pixels;
  // How much each tap of each layer deviates over the pixels. Those without samples would count as 0.
  const Tensor taps = share.permute({1, 2, 0, 3, 4}).flatten(2).flatten(0, 1);  // [N * K*K, pixels]
  const Tensor senders = taps.sum(0).gt(0);
  const Tensor sent = taps.index({torch::indexing::Slice(), senders});
  statistics.deviation = (sent.std(1, /*unbiased=*/false).sum() / sent.mean(1).sum()).item<double>();
  for (int64_t l = 0; kernels.of_layers && l < share.size(1); ++l)
    statistics.layer_share.push_back(of_layers.select(1, l).sum().item<double>() / pixels);
  return statistics;
}

KernelStatistics mean_over_processes(const KernelStatistics& own, double share, ProcessGroup& group) {
  std::vector<double> values = {own.entropy, own.centre_share, own.deviation};
  values.insert(values.end(), own.layer_share.begin(), own.layer_share.end());
  const Tensor sums = torch::tensor(values, torch::kFloat64) * share;
  group.sum({sums}, "looking at the kernels");
  const double* mean = sums.data_ptr<double>();
  return {mean[0], mean[1], {mean + 3, mean + sums.numel()}, mean[2]};
}

void add_to_row(const KernelStatistics& statistics, std::map<std::string, double>& row) {
  row["kernel_entropy"] = statistics.entropy;
  row["kernel_centre_share"] = statistics.centre_share;
  for (size_t i = 0; i < statistics.layer_share.size(); ++i)
    row[fmt::format("kernel_layer_share_{}", i + 1)] = statistics.layer_share[i];
}

}  // namespace ld
