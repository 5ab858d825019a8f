// The figures of docs/stability.md: what the formulas of [MH20] do as printed, beside what the operators do.
//   build/tests/test_stability --gtest_filter='Figures.*'
// With LD_FIGURES=FOLDER in the environment, its picture is written to that folder too.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iostream>

#include "core/file_io.h"
#include "core/text_table.h"
#include "ops/tone_map_tensor.h"
#include "plot/svg_plot.h"
#include "tests/stability/filters.h"

namespace ld {
namespace {

using torch::Tensor;

void print(const std::string& title, const std::vector<TableRow>& table) {
  std::cout << "\n" << title << "\n\n" << markdown_table(table, 0) << std::flush;
}

/// What is left of a constant picture of 1.
struct Kept {
  double worst, best, share_below;  // extremes, and the share of pixels that lost more than 0.1 %
};

Kept kept(const Tensor& result) {
  const Tensor r = result.to(torch::kFloat64);
  return {r.min().item<double>(), r.max().item<double>(),
          r.lt(0.999).to(torch::kFloat64).mean().item<double>()};
}

FilterInput constant_input(int64_t layers, int64_t kernel, int64_t side, double deviation) {
  FilterInput input = filter_input(layers, kernel, 1, side, side, deviation, 90);
  input.radiance.fill_(1);
  return input;
}

double centre(const Tensor& picture) {
  return picture[0][0][picture.size(2) / 2][picture.size(3) / 2].item<double>();
}

TEST(Figures, ALayerWhoseLogitsLieBelowThoseOfAnother) {
  std::vector<TableRow> table = {{"below by", "as printed", "as printed, double", "here"}};
  for (const double below : {10, 14, 16, 20, 30}) {
    FilterInput input = constant_input(2, 5, 15, 1);
    input.partition_logits.zero_();
    input.kernel_logits.zero_();
    input.kernel_logits.select(1, 1).fill_(-below);
    const double single = centre(filter_layers_as_printed(input, torch::kFloat32)),
                 twice = centre(filter_layers_as_printed(input, torch::kFloat64)),
                 ours = centre(input.run(Compositing::alpha));
    EXPECT_NEAR(ours, 1, 1e-6);
    if (below >= 20) {
      EXPECT_LT(twice, 0.8);
    }
    table.push_back({fmt::format("{}", below), fmt::format("{:.4f}", single), fmt::format("{:.4f}", twice),
                     fmt::format("{:.7f}", ours)});
  }
  print(
      "A constant picture of 1, two layers of equal weight, flat 5x5 kernels; the kernel logits of layer 1 "
      "lie below those of layer 0:",
      table);
}

TEST(Figures, LogitsOfGrowingDeviation) {
  std::vector<TableRow> table = {{"deviation", "as printed: pixels that lose > 0.1 %", "worst keeps",
                                  "in double: pixels", "worst keeps", "here: pixels", "largest error"}};
  LinePlot plot{"A constant picture: pixels that lose more than 0.1 %",
                "deviation of the kernel and partition logits",
                "% of the pixels",
                true,
                false,
                {{"as printed", {}}, {"as printed, double", {}}, {"here", {}}}};
  for (const double deviation : {1.0, 3.0, 10.0, 100.0, 1e3, 1e4}) {
    const FilterInput input = constant_input(2, 17, 64, deviation);
    const Kept single = kept(filter_layers_as_printed(input, torch::kFloat32)),
               twice = kept(filter_layers_as_printed(input, torch::kFloat64)),
               ours = kept(input.run(Compositing::alpha));
    const double error = std::max(1 - ours.worst, ours.best - 1);
    EXPECT_LE(error, 1e-5) << deviation;
    if (deviation >= 10) {
      EXPECT_GT(twice.share_below, 0.01);
    }
    plot.lines[0].points.emplace_back(deviation, 100 * single.share_below);
    plot.lines[1].points.emplace_back(deviation, 100 * twice.share_below);
    plot.lines[2].points.emplace_back(deviation, 100 * ours.share_below);
    const auto percent = [](double share) { return fmt::format("{:.1f} %", 100 * share); };
    table.push_back({fmt::format("{:g}", deviation), percent(single.share_below),
                     fmt::format("{:.2g}", single.worst), percent(twice.share_below),
                     fmt::format("{:.2g}", twice.worst), percent(ours.share_below),
                     fmt::format("{:.1g}", error)});
  }
  print("A constant picture of 1 in 64x64, two layers, 17x17 kernels, all logits random and normal:", table);
  const std::string svg = to_svg(plot);
  EXPECT_NE(svg.find("as printed"), std::string::npos);
  if (const char* folder = std::getenv("LD_FIGURES"))
    write_file_atomically(std::filesystem::path(folder) / "lost_energy.svg", svg);
}

TEST(Figures, KernelsThatPointOneWay) {
  std::vector<TableRow> table = {
      {"logit of that tap", "as printed: pixels that lose > 0.1 %", "worst keeps", "here: largest error"}};
  for (const double strength : {10.0, 20.0, 30.0, 100.0}) {
    FilterInput input = constant_input(1, 17, 64, 1);
    input.kernel_logits.select(2, 0).add_(strength);
    const Kept printed = kept(filter_layers_as_printed(input, torch::kFloat64)),
               ours = kept(input.run(Compositing::alpha));
    const double error = std::max(1 - ours.worst, ours.best - 1);
    EXPECT_LE(error, 1e-5) << strength;
    if (strength >= 20) {
      EXPECT_GT(printed.share_below, 0.1);
    }
    table.push_back({fmt::format("{:g}", strength), fmt::format("{:.1f} %", 100 * printed.share_below),
                     fmt::format("{:.1g}", printed.worst), fmt::format("{:.1g}", error)});
  }
  print("The same with one layer and kernels whose upper left tap is that much larger (in double):", table);
}

// Transmittance as 1 - alpha cancels behind a nearly opaque layer; as a ratio of its own it does not.
TEST(Figures, WhatANearlyOpaqueLayerLetsThrough) {
  std::vector<TableRow> table = {{"weight of the layer behind", "error of 1 - alpha", "error of the ratio"}};
  for (const double w : {1e-2, 1e-4, 1e-6, 1e-8, 1e-30}) {
    Tensor logits = torch::zeros({1, 8, 2, 1, 1});
    logits.select(2, 1).fill_(std::log(w));
    const Tensor ones = torch::ones({1, 8, 1, 1, 1}), radiance = torch::ones({1, 8, 3, 1, 1});
    const Partition p = partition(logits, ones, radiance, radiance);
    const Partition exact = partition(logits.to(torch::kFloat64), ones.to(torch::kFloat64),
                                      radiance.to(torch::kFloat64), radiance.to(torch::kFloat64));
    const double truth = exact.transmittance.flatten()[0].item<double>();
    const auto error = [&](double value) { return std::abs(value / truth - 1); };
    const double ratio = error(p.transmittance.flatten()[0].item<double>()),
                 difference = error((1 - p.opacity).flatten()[0].item<double>());
    EXPECT_LE(ratio, 1e-6) << w;
    if (w <= 1e-8) {
      EXPECT_GT(difference, 0.01);
    }
    table.push_back(
        {fmt::format("{:g}", w), fmt::format("{:.1g}", difference), fmt::format("{:.1g}", ratio)});
  }
  print("Share of a hidden firefly that reaches the picture, float32, 8 samples:", table);
}

TEST(Figures, ToneMapInTheDark) {
  std::vector<TableRow> table = {{"x", "error of log(1 + x)", "error of log1p(x)"}};
  for (const double x : {1e-1, 1e-3, 1e-5, 1e-7, 1e-8}) {
    const Tensor single = torch::full({1}, x, torch::kFloat32);
    const double exact = tone_map(single.to(torch::kFloat64)).item<double>();
    const double ours = std::abs(tone_map(single).item<double>() / exact - 1);
    // Gamma is linear in the dark; above it, the printed logarithm through the exact Gamma.
    const double printed_log = (1 + single).log().to(torch::kFloat64).item<double>();
    const double printed = std::abs(
        tone_map(torch::full({1}, std::expm1(printed_log), torch::kFloat64)).item<double>() / exact - 1);
    EXPECT_LE(ours, 1e-6) << x;
    table.push_back({fmt::format("{:g}", x), fmt::format("{:.1g}", printed), fmt::format("{:.1g}", ours)});
  }
  print("The tone map in float32, relative:", table);
}

}  // namespace
}  // namespace ld
