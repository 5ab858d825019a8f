// Every loss and every metric at every pair of extremes.
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "losses/loss.h"
#include "metrics/metric.h"
#include "tests/stability/operator_cases.h"
#include "tests/support/tensors.h"

namespace ld {
namespace {

using torch::Tensor;

/// A picture of 4x4 with `number` here and there.
Tensor picture(float number, uint32_t seed) {
  return sprinkle(random_uniform({3, 4, 4}, seed, 0, 2).to(torch::kFloat32), number, seed + 1);
}

Image to_image(const Tensor& tensor) {
  Image image(4, 4, 3);
  image.pixels.assign(tensor.data_ptr<float>(), tensor.data_ptr<float>() + tensor.numel());
  return image;
}

TEST(Scores, LossesAndTheirGradientsAreFiniteForEveryPairOfFiniteNumbers) {
  for (const std::string& name : loss_names())
    for (const float d : extreme_numbers())
      for (const float r : extreme_numbers()) {
        if (!std::isfinite(d) || !std::isfinite(r)) continue;
        const Tensor denoised = picture(d, 80).set_requires_grad(true);
        const Tensor loss = make_loss(name)(denoised, picture(r, 82));
        loss.backward();
        EXPECT_TRUE(all_finite(loss) && all_finite(denoised.grad())) << name << " of " << d << ", " << r;
        EXPECT_GT(loss.item<double>(), 0) << name << " of " << d << ", " << r;
      }
}

TEST(Scores, MetricsAreNumbersForFinitePicturesNanForBadOnesAndRefuseBadReferences) {
  for (const Metric& metric : metrics())
    for (const float d : extreme_numbers())
      for (const float r : extreme_numbers()) {
        SCOPED_TRACE(testing::Message() << metric.name << " of " << d << ", " << r);
        const Image denoised = to_image(picture(d, 84)), reference = to_image(picture(r, 86));
        if (!std::isfinite(r)) {
          EXPECT_THROW(metric.compute(denoised, reference), Error);
          continue;
        }
        const double score = metric.compute(denoised, reference);
        EXPECT_EQ(std::isfinite(score), std::isfinite(d));
        EXPECT_EQ(std::isnan(score), !std::isfinite(d));
      }
}

TEST(Scores, AnEqualPictureHasTheBestScoreAtEveryExtreme) {
  for (const Metric& metric : metrics())
    for (const float number : extreme_numbers()) {
      if (!std::isfinite(number)) continue;
      const Image image = to_image(picture(number, 88));
      const double best = metric.compute(image, image);
      EXPECT_TRUE(metric.name == "ssim" ? std::abs(best - 1) < 1e-12
                                        : best == (metric.best == Best::lowest ? 0 : INFINITY))
          << metric.name << " of " << number << ": " << best;
    }
}

}  // namespace
}  // namespace ld
