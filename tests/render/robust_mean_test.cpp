// Robust means, references in parts and what they say of themselves.
#include "render/geometry/robust_mean.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/random.h"
#include "render/trace/image_renderer.h"
#include "tests/render/test_scenes.h"

namespace ld {
namespace {

/// Estimates of 1: means of `count` draws each.
template <class Draw>
std::vector<Radiance> estimates(size_t parts, int count, uint32_t number, const Draw& draw) {
  std::vector<Radiance> result(parts);
  RandomStream random(21, RandomPurpose::test, number);
  for (Radiance& part : result)
    for (int i = 0; i < count; ++i)
      for (double& channel : part) channel += draw(random) / count;
  return result;
}

TEST(RobustMean, OfAConstantIsTheConstant) {
  for (const double value : {0.0, 1e-310, 1e-38, 0.3, 65504.0, 3e38})
    for (const size_t parts : {1, 2, 3, 6, 16, 17}) {
      const Radiance found = robust_mean(std::vector<Radiance>(parts, {value, 2 * value, 0}));
      EXPECT_DOUBLE_EQ(found[0], value);
      EXPECT_DOUBLE_EQ(found[1], 2 * value);
      EXPECT_EQ(found[2], 0);
    }
}

TEST(RobustMean, SuppressesOneFireflyAmongTheParts) {
  for (const size_t parts : {6, 8, 16, 17})
    for (const double firefly : {30.0, 1e4, 3e38})
      for (size_t place = 0; place < parts; ++place) {
        std::vector<Radiance> means(parts, {1, 0.5, 0.25});
        means[place] = {0, 0, firefly};
        const Radiance found = robust_mean(means);
        EXPECT_DOUBLE_EQ(found[0], 1);
        EXPECT_DOUBLE_EQ(found[2], 0.25);
      }
  // What a single part has seen is lost; a black pixel stays black.
  std::vector<Radiance> means(16, {0, 0, 0});
  means[7] = {5, 5, 5};
  EXPECT_EQ(robust_mean(means)[0], 0);
}

TEST(RobustMean, BecomesTheMeanWhereTailsAreLight) {
  double error_before = 1;
  for (const int count : {4, 64, 1024}) {
    double error = 0;
    for (uint32_t pixel = 0; pixel < 200; ++pixel) {
      const auto means = estimates(16, count, pixel, [](RandomStream& random) {
        return -std::log(1 - double{random.uniform()});  // exponential: mean and deviation 1
      });
      const double difference = robust_mean(means)[0] - plain_mean(means)[0];
      error += difference * difference / 200;
      if (count == 1024) {
        EXPECT_EQ(difference, 0);
      }
    }
    EXPECT_LE(std::sqrt(error), 0.5 * error_before);
    error_before = std::sqrt(error);
  }
}

TEST(RobustMean, LeavesFaultsVisible) {
  std::vector<Radiance> means(8, {1, 1, 1});
  means[3][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isnan(robust_mean(means)[1]));
  EXPECT_EQ(robust_mean(means)[0], 1);
  means[3][1] = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(std::isinf(robust_mean(means)[1]));
}

TEST(GiniCoefficient, IsHalfTheMeanDifferenceOverTheMean) {
  const std::vector<double> values = {0, 0.25, 1, 1, 7};
  double differences = 0;
  for (const double a : values)
    for (const double b : values) differences += std::abs(a - b);
  EXPECT_NEAR(gini_coefficient(values), differences / (2 * 5 * 9.25), 1e-12);
  EXPECT_EQ(gini_coefficient({0, 0, 0}), 0);
  EXPECT_EQ(gini_coefficient({4, 4}), 0);
  EXPECT_NEAR(gini_coefficient({0, 0, 0, 3}), 0.75, 1e-15);
}

/// A ball under a lamp.
PreparedScene small_scene() {
  Scene scene;
  scene.objects.push_back({make_sphere(3), 0, {}});
  scene.materials.push_back(plain_material(MaterialKind::plastic, grey(0.6F), 0.2F));
  scene.lights.push_back({{2, 3, -0.5F}, {1, 0, 0}, {0, 0, 1}, grey(5)});
  scene.sky = constant_sky(0.2F);
  scene.camera = simple_camera({3, 2, 0}, {}, 0.8F, 12);
  return PreparedScene(scene);
}

RenderSettings in_parts(int spp, int parts, bool robust, int threads = 1) {
  RenderSettings settings;
  settings.seed = 5;
  settings.spp = spp;
  settings.reference_parts = parts;
  settings.robust_reference = robust;
  settings.threads = threads;
  return settings;
}

TEST(ReferenceParts, AreIndependentAndTheFirstIsAReferenceByItself) {
  const PreparedScene scene = small_scene();
  ReferenceHalves halves;
  const Image whole = *render_reference(scene, in_parts(16, 2, false), &halves);
  EXPECT_EQ(halves.first.pixels, render_reference(scene, in_parts(8, 1, false))->pixels);
  EXPECT_NE(halves.first.pixels, halves.second.pixels);
  for (size_t i = 0; i < whole.pixels.size(); ++i)
    EXPECT_NEAR(whole.pixels[i], (halves.first.pixels[i] + halves.second.pixels[i]) / 2,
                1e-6F * whole.pixels[i]);
}

TEST(ReferenceParts, AreTheSameBitsWithAnyNumberOfThreads) {
  const PreparedScene scene = small_scene();
  ReferenceHalves one, three;
  RenderSettings settings = in_parts(24, 6, true);
  settings.path.regularisation = 0.3F;
  settings.path.indirect_clamp = 2;
  const Image expected = *render_reference(scene, settings, &one);
  settings.threads = 3;
  EXPECT_EQ(render_reference(scene, settings, &three)->pixels, expected.pixels);
  EXPECT_EQ(three.first.pixels, one.first.pixels);
  EXPECT_EQ(three.second.pixels, one.second.pixels);
}

}  // namespace
}  // namespace ld
