#include "training/held_out.h"

#include <fmt/format.h>

#include <charconv>
#include <limits>

#include "core/error.h"
#include "core/file_io.h"
#include "losses/relative_l2.h"

namespace ld {
namespace {

constexpr int kScaleSide = 5;
constexpr const char* kHeader = "block,beginning\n";

std::filesystem::path file_in(const std::filesystem::path& run) {
  return run / "held_out.csv";
}

/// [1, 3, H, W]: 1 / sqrt(s^2 + epsilon).
torch::Tensor inverse_scale(const NetworkInput& input) {
  const torch::Tensor count = input.valid.sum(1).clamp_min(1);
  const torch::Tensor mean = (input.radiance * input.valid / count.unsqueeze(1)).sum(1);
  const torch::Tensor smooth = at::avg_pool2d(mean, kScaleSide, 1, kScaleSide / 2, /*ceil_mode=*/false,
                                              /*count_include_pad=*/false);
  return at::hypot(smooth, at::full_like(smooth, std::sqrt(kRelativeL2Epsilon))).reciprocal();
}

}  // namespace

int64_t blocks_of(int width, int height) {
  const auto along = [](int side) { return int64_t{(side + kBlockSide - 1) / kBlockSide}; };
  return along(width) * along(height);
}

std::vector<double> block_errors(const torch::Tensor& denoised, const Batch& batch) {
  const torch::NoGradGuard no_graph;
  const torch::Tensor error = ((denoised - batch.reference) * inverse_scale(batch.input)).to(torch::kFloat64);
  const torch::Tensor squares =
      error.square().mean(1, /*keepdim=*/true).clamp_max(std::numeric_limits<float>::max());
  const torch::Tensor blocks = at::avg_pool2d(squares, kBlockSide, kBlockSide, 0, /*ceil_mode=*/true,
                                              /*count_include_pad=*/false)
                                   .contiguous();
  const double* first = blocks.data_ptr<double>();
  return {first, first + blocks.numel()};
}

std::optional<double> sample_correlation(const torch::Tensor& denoised, const Batch& batch) {
  const torch::NoGradGuard no_graph;
  const int64_t samples = batch.input.radiance.size(1), width = batch.input.radiance.size(4);
  if (samples < 2 || width < 2) return std::nullopt;
  const torch::Tensor scale = inverse_scale(batch.input).unsqueeze(1);
  const torch::Tensor residual =
      ((batch.input.radiance - denoised.unsqueeze(1)) * scale * batch.input.valid).to(torch::kFloat64);
  const torch::Tensor sum = residual.sum(1);
  // Over pairs of different samples: all pairs less those of a sample with itself.
  const auto products = [&](int64_t shift) {
    const int64_t columns = width - 1;
    const torch::Tensor all = sum.narrow(3, 0, columns) * sum.narrow(3, shift, columns);
    const torch::Tensor own = (residual.narrow(4, 0, columns) * residual.narrow(4, shift, columns)).sum(1);
    return (all - own).mean().item<double>() / static_cast<double>(samples * (samples - 1));
  };
  const double common = products(0) - products(1);
  const double within = (residual - residual.mean(1, true)).square().sum(1).mean().item<double>() /
                        static_cast<double>(samples - 1);
  if (!(common + within > 0)) return std::nullopt;
  return common / (common + within);
}

HeldOutComparison compare_blocks(const std::vector<double>& beginning, const std::vector<double>& now) {
  if (beginning.size() != now.size())
    fail("{} blocks of held-out frames, but {} when the run began; the data have changed: begin a new run",
         now.size(), beginning.size());
  HeldOutComparison comparison;
  std::vector<double> differences;
  for (size_t i = 0; i < now.size(); ++i) {
    comparison.beginning += beginning[i] / static_cast<double>(now.size());
    comparison.now += now[i] / static_cast<double>(now.size());
    differences.push_back(now[i] - beginning[i]);
  }
  const std::optional<Interval> interval = mean_interval(differences);
  if (!interval) fail("{} blocks of held-out frames with finite errors; expected at least two", now.size());
  comparison.difference = *interval;
  return comparison;
}

void write_beginning(const std::filesystem::path& run, const std::vector<double>& errors) {
  std::string text = kHeader;
  for (size_t i = 0; i < errors.size(); ++i) text += fmt::format("{},{}\n", i, errors[i]);
  write_file_atomically(file_in(run), text);
}

std::vector<double> read_beginning(const std::filesystem::path& run) {
  const std::filesystem::path path = file_in(run);
  const std::string text = read_file(path);
  const auto damaged = [&] {
    fail("{}: damaged; it holds the errors that this run began with: begin a new run", path.string());
  };
  if (text.rfind(kHeader, 0) != 0) damaged();
  std::vector<double> errors;
  for (size_t at = std::string(kHeader).size(); at < text.size();) {
    const size_t comma = text.find(',', at), end = text.find('\n', at);
    if (comma >= end || end == std::string::npos ||
        text.substr(at, comma - at) != std::to_string(errors.size()))
      damaged();
    double value = 0;
    const auto [last, error] = std::from_chars(text.data() + comma + 1, text.data() + end, value);
    if (error != std::errc() || last != text.data() + end) damaged();
    errors.push_back(value);
    at = end + 1;
  }
  return errors;
}

}  // namespace ld
