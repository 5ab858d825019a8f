// Random scenes: seeded, varied, renderable.
#include "render/random_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "render/image_renderer.h"

namespace ld {
namespace {

RenderSettings settings_for(uint64_t seed, uint32_t frame, int spp, int threads) {
  RenderSettings settings;
  settings.seed = seed;
  settings.frame = frame;
  settings.spp = spp;
  settings.threads = threads;
  return settings;
}

TEST(RandomScene, SharesAndVariety) {
  SceneConfig config;
  int indoor = 0, defocus = 0, motion = 0;
  std::set<int> kinds, patterns;
  constexpr int kScenes = 200;
  for (uint32_t frame = 0; frame < kScenes; ++frame) {
    const Scene scene = random_scene(config, 1, frame, 0, 64, 64);
    const bool is_indoor = scene.name.rfind("indoor", 0) == 0;
    indoor += is_indoor;
    EXPECT_EQ(is_indoor, !scene.sky.has_value());
    EXPECT_EQ(is_indoor, !scene.lights.empty());
    defocus += scene.camera.lens_radius > 0;
    const bool moves = std::any_of(scene.objects.begin(), scene.objects.end(),
                                   [](const Object& object) { return !object.motion.still(); });
    motion += scene.camera.shutter;
    EXPECT_FALSE(moves && !scene.camera.shutter);
    for (const Material& material : scene.materials) {
      kinds.insert(static_cast<int>(material.kind));
      patterns.insert(static_cast<int>(material.colour.pattern));
    }
    // 30 at most, and floor, walls and the backs of four lamps.
    EXPECT_GE(scene.objects.size(), 7U);
    EXPECT_LE(scene.objects.size(), 40U);
  }
  EXPECT_EQ(indoor, kScenes / 2);
  // Four standard deviations of 200 fair coins.
  EXPECT_NEAR(defocus, 100, 28);
  EXPECT_NEAR(motion, 100, 28);
  EXPECT_EQ(kinds.size(), 5U);
  EXPECT_EQ(patterns.size(), 7U);
}

TEST(RandomScene, ShareOfRoomsIsKeptExactly) {
  SceneConfig config;
  config.indoor = 0.25;
  int indoor = 0;
  for (uint32_t frame = 0; frame < 40; ++frame)
    indoor += random_scene(config, 1, frame, 0, 8, 8).name.rfind("indoor", 0) == 0;
  EXPECT_EQ(indoor, 10);
}

TEST(RandomScene, FramesAreBitIdenticalWhateverTheThreads) {
  const SceneConfig config;
  for (const uint32_t frame : {0U, 1U}) {
    const auto scene = prepare_random_scene(config, 3, frame, 24, 20);
    const Frame one = *render_samples(*scene, settings_for(3, frame, 2, 1));
    const Image reference = *render_reference(*scene, settings_for(3, frame, 4, 1));
    for (const int threads : {2, 3}) {
      const auto again = prepare_random_scene(config, 3, frame, 24, 20);
      EXPECT_EQ(render_samples(*again, settings_for(3, frame, 2, threads))->samples, one.samples);
      EXPECT_EQ(render_reference(*again, settings_for(3, frame, 4, threads))->pixels, reference.pixels);
    }
  }
}

TEST(RandomScene, SeedsFramesAndPurposesDiffer) {
  const SceneConfig config;
  const auto picture = [&](uint64_t seed, uint32_t frame) {
    return render_samples(*prepare_random_scene(config, seed, frame, 16, 16), settings_for(seed, frame, 1, 1))
        ->samples;
  };
  const auto base = picture(1, 0);
  EXPECT_EQ(picture(1, 0), base);
  EXPECT_NE(picture(2, 0), base);
  EXPECT_NE(picture(1, 2), base);
  // One and the same scene: the reference's samples are others than the frame's.
  const auto scene = prepare_random_scene(config, 1, 1, 16, 16);
  const Image input = mean_radiance(*render_samples(*scene, settings_for(1, 1, 4, 1)));
  const Image reference = *render_reference(*scene, settings_for(1, 1, 4, 1));
  size_t different = 0;
  for (size_t i = 0; i < input.pixels.size(); ++i) different += input.pixels[i] != reference.pixels[i];
  EXPECT_GT(different, input.pixels.size() * 9 / 10);
}

TEST(RandomScene, PicturesAreSoundAndWellExposed) {
  const SceneConfig config;
  for (uint32_t frame = 0; frame < 16; ++frame) {
    SCOPED_TRACE(frame);
    const auto scene = prepare_random_scene(config, 9, frame, 24, 24);
    const Frame samples = *render_samples(*scene, settings_for(9, frame, 8, 2));
    int64_t bad = 0, negative = 0;
    for (const float value : samples.samples) bad += !std::isfinite(value);
    for (int s = 0; s < samples.spp; ++s)
      for (int c = 0; c < 3; ++c)
        for (size_t p = 0; p < samples.plane_size(); ++p) negative += samples.plane(s, c)[p] < 0;
    EXPECT_EQ(bad, 0);
    EXPECT_EQ(negative, 0);
    std::vector<float> luminances;
    const Image mean = mean_radiance(samples);
    for (size_t p = 0; p < mean.plane_size(); ++p)
      luminances.push_back(luminance({mean.plane(0)[p], mean.plane(1)[p], mean.plane(2)[p]}));
    const auto middle = luminances.begin() + static_cast<std::ptrdiff_t>(luminances.size() / 2);
    std::nth_element(luminances.begin(), middle, luminances.end());
    EXPECT_GT(*middle, 0.05F);
    EXPECT_LT(*middle, 1.0F);
    for (int s = 0; s < samples.spp; ++s)
      for (size_t p = 0; p < samples.plane_size(); ++p) {
        const Vec3 n = {samples.plane(s, 3)[p], samples.plane(s, 4)[p], samples.plane(s, 5)[p]};
        const bool escaped = samples.plane(s, kDepthOffset)[p] == kEscapedDepth;
        ASSERT_NEAR(length(n), escaped ? 0 : 1, 1e-4);
        ASSERT_GT(samples.plane(s, kDepthOffset)[p], 0);
      }
  }
}

TEST(RandomScene, StopsWhenAsked) {
  const auto scene = prepare_random_scene({}, 1, 0, 16, 16);
  RenderSettings settings = settings_for(1, 0, 1, 2);
  settings.stop = [] { return true; };
  EXPECT_FALSE(render_samples(*scene, settings).has_value());
  EXPECT_FALSE(render_reference(*scene, settings).has_value());
}

}  // namespace
}  // namespace ld
