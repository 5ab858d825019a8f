// What holds bit for bit: scaling by powers of two, shifting all logits of a pixel, and that a bad sample is
// local.
#include <gtest/gtest.h>

#include <limits>

#include "ops/kernel_gather.h"
#include "tests/stability/filters.h"

namespace ld {
namespace {

using torch::Tensor;

/// All filters with given logits, by name.
struct Filter {
  const char* name;
  std::function<Tensor(const FilterInput&)> run;
};

std::vector<Filter> filters() {
  return {{"layers, alpha", [](const FilterInput& input) { return input.run(Compositing::alpha); }},
          {"layers, weighted", [](const FilterInput& input) { return input.run(Compositing::weighted); }},
          {"sample splat",
           [](const FilterInput& input) {
             // Layers stand for samples; as many of both.
             const Tensor finite = input.radiance.isfinite().all(2);
             const Tensor log_n =
                 torch::zeros(finite.sizes())
                     .masked_fill(finite.logical_not(), -std::numeric_limits<float>::infinity());
             return kernel_splat_joint(input.kernel_logits, log_n, input.radiance);
           }},
          {"pixel gather", [](const FilterInput& input) {
             return kernel_gather(input.kernel_logits.select(1, 0), torch::zeros({1, 15, 17}),
                                  input.radiance.select(1, 0));
           }}};
}

FilterInput some_input(double deviation = 3) {
  return filter_input(3, 5, 3, 15, 17, deviation, 60);
}

TEST(Properties, RadianceTimesAPowerOfTwoIsTheResultTimesItBitForBit) {
  for (const Filter& filter : filters())
    for (const double power : {1 << 20, 1 << 3}) {
      FilterInput input = some_input();
      const Tensor before = filter.run(input);
      input.radiance = input.radiance * power;
      EXPECT_TRUE(filter.run(input).equal(before * power)) << filter.name;
      input.radiance = input.radiance / (power * power);
      EXPECT_TRUE(filter.run(input).equal(before / power)) << filter.name;
    }
}

TEST(Properties, Adding1024ToTheLogitsOfAPixelChangesNoBit) {
  const auto grid = [](const Tensor& logits) { return (logits * 1024).round() / 1024; };
  const Tensor shift = (random_uniform({15, 17}, 61).lt(0.5).to(torch::kFloat32) * 1024);
  for (const Filter& filter : filters()) {
    FilterInput input = some_input(30);
    input.partition_logits = grid(input.partition_logits);
    input.kernel_logits = grid(input.kernel_logits);
    const Tensor before = filter.run(input);
    input.partition_logits = input.partition_logits + shift;
    input.kernel_logits = input.kernel_logits + shift;
    EXPECT_TRUE(filter.run(input).equal(before)) << filter.name;
  }
}

// Radiance of one sample at (7, 8) turns bad: with given logits nothing changes beyond the 5 x 5 kernel's
// reach, and within it everything is finite.
TEST(Properties, ABadSampleIsLocalBitForBit) {
  for (const Filter& filter : filters())
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity(), 3e38F}) {
      FilterInput input = some_input();
      const Tensor before = filter.run(input);
      input.radiance = input.radiance.clone();
      input.radiance[0][0][1][7][8] = bad;
      const Tensor after = filter.run(input);
      EXPECT_TRUE(all_finite(after)) << filter.name << ", " << bad;
      Tensor outside = torch::ones({15, 17}, torch::kBool);
      outside.narrow(0, 5, 5).narrow(1, 6, 5).fill_(false);
      EXPECT_TRUE(after.masked_select(outside).equal(before.masked_select(outside)))
          << filter.name << ", " << bad;
      EXPECT_FALSE(after.equal(before)) << filter.name << ": the sample was not in use, " << bad;
    }
}

// What a bad sample leaves is what its removal leaves.
TEST(Properties, ABadSampleIsLikeOneThatWasRemoved) {
  for (const Compositing compositing : {Compositing::alpha, Compositing::weighted}) {
    FilterInput bad = some_input(), removed = bad;
    bad.radiance = bad.radiance.clone();
    bad.radiance[0][0][1][7][8] = std::numeric_limits<float>::quiet_NaN();
    removed.valid = removed.valid.clone();
    removed.valid[0][0][0][7][8] = 0;
    EXPECT_TRUE(bad.run(compositing).equal(removed.run(compositing)));
  }
}

}  // namespace
}  // namespace ld
