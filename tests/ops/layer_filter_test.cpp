// Partition, splat and compositing together: what the stable formulation promises.
#include <gtest/gtest.h>

#include <cmath>

#include "losses/loss.h"
#include "models/compositor.h"
#include "ops/kernel_splat.h"
#include "ops/partition.h"
#include "tests/support/gradient_check.h"
#include "tests/support/scalar_reference.h"

namespace ld {
namespace {

using torch::Tensor;

Tensor denoise(const Tensor& kernels, const Tensor& logits, const Tensor& valid, const Tensor& radiance) {
  const Partition p = partition(logits, valid, radiance, at::zeros_like(radiance));
  const Tensor filtered = kernel_splat(kernels, p.log_n, at::cat({p.radiance, p.transmittance}, 2));
  return composite_alpha(filtered.narrow(2, 0, 3), filtered.narrow(2, 3, 1));
}

TEST(LayerFilter, AgreesWithThePaperAsPrinted) {
  for (const int64_t layers : {1, 2, 4}) {
    const Tensor kernels = random_normal({2, layers, 9, 5, 7}, 1),
                 logits = random_normal({2, 3, layers, 5, 7}, 2);
    const Tensor valid = random_valid(2, 3, 5, 7, 3),
                 radiance = random_uniform({2, 3, 3, 5, 7}, 4, 0, 9) * valid;
    const auto sums =
        reference::partition(to_grid(logits), to_grid(valid), to_grid(radiance), to_grid(radiance));
    const auto k = to_grid(kernels);
    const auto expected =
        reference::composite(reference::splat(k, sums.radiance), reference::splat(k, sums.weight),
                             reference::splat(k, sums.occupancy));
    expect_near(denoise(kernels, logits, valid, radiance), to_tensor(expected).squeeze(1), 1e-11);
  }
}

TEST(LayerFilter, AConstantImageStaysConstant) {
  for (int64_t layers = 1; layers <= 4; ++layers)
    for (const double deviation : {1.0, 10.0, 100.0, 1e3, 1e4}) {
      const Tensor kernels = random_normal({2, layers, 25, 12, 11}, 1, deviation).to(torch::kFloat32);
      const Tensor logits = random_normal({2, 3, layers, 12, 11}, 2, deviation).to(torch::kFloat32);
      const Tensor valid = random_valid(2, 3, 12, 11, 3).to(torch::kFloat32);
      const Tensor out = denoise(kernels, logits, valid, valid.expand({2, 3, 3, 12, 11}) * 0.7);
      EXPECT_LE((out / 0.7 - 1).abs().max().item<double>(), 1e-5)
          << layers << " layers, deviation " << deviation;
    }
}

TEST(LayerFilter, AConstantImageStaysConstantForTheLargestLogits) {
  for (int64_t layers = 1; layers <= 3; ++layers) {
    // Differences of these logits overflow: at many pixels everything that arrives has an exponent of -6e38.
    const Tensor kernels = (random_normal({1, layers, 9, 9, 8}, 1).sign() * 3e38).to(torch::kFloat32);
    const Tensor logits = (random_normal({1, 2, layers, 9, 8}, 2).sign() * 3e38).to(torch::kFloat32);
    const Tensor out = denoise(kernels, logits, torch::ones({1, 2, 1, 9, 8}), torch::ones({1, 2, 3, 9, 8}));
    EXPECT_LE((out - 1).abs().max().item<double>(), 1e-5) << layers << " layers";
  }
}

TEST(LayerFilter, KernelsThatPointOneWayKeepTheBorder) {
  for (const int64_t tap : {0, 2, 4, 6, 8}) {
    Tensor kernels = torch::full({1, 2, 9, 6, 6}, -300.0);
    kernels.select(2, tap).fill_(300);
    const Tensor logits = random_normal({1, 2, 2, 6, 6}, 5, 20).to(torch::kFloat32);
    const Tensor out = denoise(kernels, logits, torch::ones({1, 2, 1, 6, 6}), torch::ones({1, 2, 3, 6, 6}));
    EXPECT_LE((out - 1).abs().max().item<double>(), 1e-5) << tap;
  }
}

TEST(LayerFilter, TheResultLiesWithinTheSamples) {
  for (const double deviation : {1.0, 30.0, 1e3}) {
    const Tensor kernels = random_normal({1, 3, 25, 9, 9}, 1, deviation).to(torch::kFloat32);
    const Tensor logits = random_normal({1, 4, 3, 9, 9}, 2, deviation).to(torch::kFloat32);
    const Tensor radiance = random_uniform({1, 4, 3, 9, 9}, 3, 2, 5).to(torch::kFloat32);
    const Tensor out = denoise(kernels, logits, torch::ones({1, 4, 1, 9, 9}), radiance);
    EXPECT_GE(out.min().item<double>(), radiance.min().item<double>() * (1 - 1e-5));
    EXPECT_LE(out.max().item<double>(), radiance.max().item<double>() * (1 + 1e-5));
  }
}

TEST(LayerFilter, AFireflyBehindANearlyOpaqueLayer) {
  // Two pixels. The left one has w in layer 1 and 1 - w in layer 0; the right one lies in layer 1 alone, is
  // 1/w bright, and its layer 0 goes astray. At the left pixel: 1 * (1 - w) in front, and w * (1/w) through
  // it.
  for (const double w : {1e-4, 1e-6, 1e-12, 1e-30}) {
    Tensor logits = torch::zeros({1, 1, 2, 1, 2});
    logits[0][0][0][0][0] = -std::log(w);
    logits[0][0][1][0][1] = 200;
    Tensor radiance = torch::ones({1, 1, 3, 1, 2});
    radiance.select(4, 1).fill_(1 / w);
    Tensor kernels = torch::zeros({1, 2, 9, 1, 2});
    kernels.select(1, 0).select(3, 1).fill_(-500);
    const Tensor out = denoise(kernels, logits, torch::ones({1, 1, 1, 1, 2}), radiance);
    // Layer 1 at the left: its own share w of 1 beside the firefly's share 1 of 1/w; T = w/(1 + w) there.
    const double t = w / (1 + w), front = 1 / (1 + w), behind = (t * 1 + 1 / w) / (t + 1);
    EXPECT_NEAR(out[0][0][0][0].item<double>(), front + t * behind, 2e-6) << w;
  }
}

TEST(LayerFilter, TheOrderOfSamplesDoesNotMatter) {
  const Tensor kernels = random_normal({1, 2, 9, 4, 5}, 1).to(torch::kFloat32);
  const Tensor logits = random_normal({1, 6, 2, 4, 5}, 2, 3).to(torch::kFloat32);
  const Tensor valid = random_valid(1, 6, 4, 5, 3).to(torch::kFloat32);
  const Tensor radiance = random_uniform({1, 6, 3, 4, 5}, 4).to(torch::kFloat32) * valid;
  const Tensor order = torch::tensor({3, 0, 5, 1, 4, 2});
  expect_near(denoise(kernels, logits.index_select(1, order), valid.index_select(1, order),
                      radiance.index_select(1, order)),
              denoise(kernels, logits, valid, radiance), 2e-6);
}

TEST(LayerFilter, ExtremesStayFinite) {
  const std::vector<double> radiances = {0, 1e-40, 1e-38, 1, 65504, 1e30, 3e38};
  const std::vector<double> sizes = {0, 1e-40, 1e-38, 1, 65504, 1e30, 3e38};
  const Tensor sign = random_normal({1, 2, 9, 4, 4}, 1).sign(),
               partition_sign = random_normal({1, 3, 2, 4, 4}, 2).sign();
  const Tensor valid = random_valid(1, 3, 4, 4, 3).to(torch::kFloat32);
  const Tensor bright = random_uniform({1, 3, 1, 4, 4}, 4).gt(0.5).to(torch::kFloat32) * valid;
  for (const std::string& name : loss_names())
    for (const double radiance : radiances)
      for (const double size : sizes) {
        const Tensor kernels = variable((sign * size).to(torch::kFloat32));
        const Tensor logits = variable((partition_sign * size).to(torch::kFloat32));
        // Half of the samples at the extreme, the others at 1.
        const Tensor light = variable((valid + bright * (radiance - 1)).expand({1, 3, 3, 4, 4}));
        const Tensor out = denoise(kernels, logits, valid, light);
        make_loss(name)(out, torch::ones({1, 3, 4, 4})).backward();
        EXPECT_TRUE(all_finite(out)) << radiance << " " << size;
        for (const Tensor& t : {kernels, logits, light})
          EXPECT_TRUE(all_finite(t.grad())) << name << " " << radiance << " " << size;
      }
}

TEST(LayerFilter, TheLargestRadianceWithoutWeightGivesNoGradient) {
  // Where the weight of a value near the largest float is 0, so is its gradient: not 0 * infinity.
  Tensor kernels = torch::zeros({1, 1, 9, 1, 2});
  kernels.select(2, 4).select(3, 1).fill_(500);  // the right pixel keeps its light to itself
  kernels.set_requires_grad(true);
  Tensor bright = torch::ones({1, 1, 1, 1, 2});
  bright.select(4, 1).fill_(3e38);
  const Tensor left = kernel_splat(kernels, torch::zeros({1, 1, 1, 2}), bright).select(4, 0);
  EXPECT_EQ(left.item<float>(), 1);
  (left * 10).sum().backward();
  EXPECT_TRUE(kernels.grad().eq(0).all().item<bool>());

  Tensor logits = torch::zeros({1, 2, 2, 1, 1});
  logits[0][1][1] = -500;  // the second sample is not in layer 1
  logits.set_requires_grad(true);
  Tensor radiance = torch::ones({1, 2, 3, 1, 1});
  radiance[0][1].fill_(3e38);
  const Partition p = partition(logits, torch::ones({1, 2, 1, 1, 1}), radiance, at::zeros_like(radiance));
  EXPECT_NEAR(p.radiance[0][1][0].item<double>(), 1, 1e-6);
  (p.radiance.select(1, 1) * 10).sum().backward();
  EXPECT_TRUE(all_finite(logits.grad()));
  EXPECT_EQ(logits.grad()[0][1][1].item<float>(), 0);
}

}  // namespace
}  // namespace ld
