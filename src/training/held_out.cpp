#include "training/held_out.h"

#include <fmt/format.h>

#include <charconv>

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

torch::Tensor smooth(const torch::Tensor& picture) {
  return at::avg_pool2d(picture, kScaleSide, 1, kScaleSide / 2, /*ceil_mode=*/false,
                        /*count_include_pad=*/false);
}

/// The samples' mean and their variance about it, [1, 3, H, W] in double: squares of floats do not overflow
/// there.
struct Spread {
  torch::Tensor mean, variance;
};

Spread spread_of(const NetworkInput& input) {
  const torch::Tensor count = input.valid.sum(1).to(torch::kFloat64);
  Spread spread = {torch::zeros_like(input.radiance.select(1, 0), torch::kFloat64), {}};
  spread.variance = torch::zeros_like(spread.mean);
  const auto each = [&](const auto& add) {
    for (int64_t s = 0; s < input.radiance.size(1); ++s)
      add(input.radiance.select(1, s).to(torch::kFloat64), input.valid.select(1, s));
  };
  each([&](const torch::Tensor& sample, const torch::Tensor& valid) { spread.mean += sample * valid; });
  spread.mean /= count.clamp_min(1);
  each([&](const torch::Tensor& sample, const torch::Tensor& valid) {
    spread.variance += (sample - spread.mean).square() * valid;
  });
  spread.variance /= (count - 1).clamp_min(1);
  return spread;
}

/// 1 / sqrt(s^2 + v + epsilon).
torch::Tensor inverse_scale(const Spread& spread) {
  return (smooth(spread.mean).square() + smooth(spread.variance) + kRelativeL2Epsilon).rsqrt();
}

}  // namespace

int64_t blocks_of(int width, int height) {
  const auto along = [](int side) { return int64_t{(side + kBlockSide - 1) / kBlockSide}; };
  return along(width) * along(height);
}

std::vector<double> block_errors(const torch::Tensor& denoised, const Batch& batch, int targets) {
  const torch::NoGradGuard no_graph;
  const Spread spread = spread_of(batch.input);
  const torch::Tensor scale = inverse_scale(spread);
  const torch::Tensor distance = ((denoised.to(torch::kFloat64) - batch.reference) * scale).square();
  const torch::Tensor error =
      (distance - spread.variance * scale.square() / targets).mean(1, /*keepdim=*/true);
  const torch::Tensor blocks = at::avg_pool2d(error, kBlockSide, kBlockSide, 0, /*ceil_mode=*/true,
                                              /*count_include_pad=*/false)
                                   .contiguous();
  const double* first = blocks.data_ptr<double>();
  return {first, first + blocks.numel()};
}

std::optional<double> sample_correlation(const torch::Tensor& denoised, const Batch& batch) {
  const torch::NoGradGuard no_graph;
  const NetworkInput& input = batch.input;
  const int64_t samples = input.radiance.size(1), columns = input.radiance.size(4) - 1;
  if (samples < 2 || columns < 1) return std::nullopt;
  const Spread spread = spread_of(input);
  const torch::Tensor scale = inverse_scale(spread), picture = denoised.to(torch::kFloat64);
  // Over pairs of different samples: all pairs less those of a sample with itself.
  torch::Tensor sum = torch::zeros_like(picture);
  double own[2] = {0, 0};
  const auto product = [&](const torch::Tensor& residual, int64_t shift) {
    return (residual.narrow(3, 0, columns) * residual.narrow(3, shift, columns)).mean().item<double>();
  };
  for (int64_t s = 0; s < samples; ++s) {
    const torch::Tensor residual = (input.radiance.select(1, s) - picture) * scale * input.valid.select(1, s);
    sum += residual;
    for (int64_t shift = 0; shift < 2; ++shift) own[shift] += product(residual, shift);
  }
  const double pairs = static_cast<double>(samples * (samples - 1));
  const double common = (product(sum, 0) - own[0] - product(sum, 1) + own[1]) / pairs;
  const double within = (spread.variance * scale.square()).mean().item<double>();
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
