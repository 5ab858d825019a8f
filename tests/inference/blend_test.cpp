#include "inference/blend.h"

#include <gtest/gtest.h>

#include <cmath>
#include <regex>
#include <string>

#include "core/error.h"
#include "core/random.h"
#include "frame/frame_file.h"
#include "inference/denoise_job.h"
#include "inference/denoiser.h"
#include "models/network_config.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/temporary_folder.h"
#include "weights/weight_file.h"

namespace ld {
namespace {

constexpr int kSide = 32;
constexpr float kTruth = 0.5F;

/// Samples about kTruth, exponentially distributed.
Frame exponential_frame(int spp, uint32_t number = 0) {
  Frame frame = random_frame(kSide, kSide, spp, number);
  std::fill(frame.valid.begin(), frame.valid.end(), uint8_t{1});
  for (int s = 0; s < spp; ++s)
    for (int c = 0; c < 3; ++c)
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        RandomStream stream(5, RandomPurpose::test, number, uint32_t(3 * s + c), uint32_t(p));
        frame.plane(s, kRadianceOffset + c)[p] = -kTruth * std::log(1 - float(stream.uniform()));
      }
  return frame;
}

Image constant(float value) {
  Image image(kSide, kSide, 3);
  std::fill(image.pixels.begin(), image.pixels.end(), value);
  return image;
}

double squared_error(const Image& image) {
  double sum = 0;
  for (const float value : image.pixels)
    sum += double(value - kTruth) * (value - kTruth) / double(image.pixels.size());
  return sum;
}

double mean_weight(const Blended& blended) {
  double sum = 0;
  for (const float value : blended.weight.pixels) sum += value / double(blended.weight.pixels.size());
  return sum;
}

/// As if a denoiser gave `value` everywhere, whatever the samples.
Blended blended_with(float value, int spp) {
  const Image picture = constant(value);
  return blend_with_mean(exponential_frame(spp), picture, picture, picture);
}

TEST(Blend, AConstantOffsetIsBlendedAwayAsSamplesGrow) {
  const float offset = 0.1F;
  double last = 1;
  for (int spp = 4; spp <= 1024; spp *= 4) {
    const double weight = mean_weight(blended_with(kTruth + offset, spp));
    // v / (v + b^2) with v = truth^2 / spp.
    const double v = double(kTruth) * double(kTruth) / spp, expected = v / (v + offset * offset);
    EXPECT_LE(weight, last + 1e-3) << spp;
    if (spp >= 64) {
      EXPECT_NEAR(weight, expected, 0.35 * expected) << spp;
    }
    last = weight;
  }
  EXPECT_LT(last, 0.05);
}

TEST(Blend, TheTruthIsKept) {
  for (const int spp : {2, 8, 64, 512}) EXPECT_GT(mean_weight(blended_with(kTruth, spp)), 0.95) << spp;
}

TEST(Blend, TheErrorFallsWithEveryFourfoldNumberOfSamples) {
  for (const float offset : {0.0F, 0.1F}) {
    double last = 1e9;
    for (int spp = 2; spp <= 512; spp *= 4) {
      const double error = squared_error(blended_with(kTruth + offset, spp).picture);
      // What is exactly true is doubted a little: by a hundredth of the mean's variance at most.
      EXPECT_LE(error, last * 1.02 + 0.01 * kTruth * kTruth / spp) << offset << " at " << spp;
      last = error;
    }
  }
}

// Of many samples the noise is known well, and what is left at one pixel of a window is the denoiser's.
TEST(Blend, AnErrorInOnePixelIsFoundAmongManySamples) {
  const Frame frame = exponential_frame(1024);
  Image picture = constant(kTruth);
  const size_t lost = frame.plane_size() / 2 + kSide / 2;
  for (int c = 0; c < 3; ++c) picture.plane(c)[lost] = kTruth + 0.3F;
  const Blended blended = blend_with_mean(frame, picture, picture, picture);
  EXPECT_LT(blended.weight.pixels[lost], 0.3F);
  EXPECT_NEAR(blended.picture.pixels[lost], kTruth, 0.1F);
  EXPECT_GT(blended.weight.pixels[0], 0.9F);
}

// Where the denoiser is right everywhere, chance must not let the mean in at a few pixels.
TEST(Blend, ATrueWallStaysFreeOfSpecks) {
  for (const int spp : {8, 32, 64})
    for (uint32_t number = 0; number < 8; ++number) {
      const Image picture = constant(kTruth);
      const Blended blended = blend_with_mean(exponential_frame(spp, number), picture, picture, picture);
      for (const float weight : blended.weight.pixels) ASSERT_GT(weight, 0.8F) << spp << ", " << number;
    }
}

TEST(Blend, OneBrightSampleLeavesNoSpeck) {
  // A denoiser that is a little off everywhere, so that the mean is mixed in, and one sample a thousand times
  // too bright.
  Frame frame = exponential_frame(64);
  const size_t firefly = frame.plane_size() / 2 + kSide / 2;
  for (int c = 0; c < 3; ++c) frame.plane(5, kRadianceOffset + c)[firefly] = 1000 * kTruth;
  const Image picture = constant(kTruth + 0.3F);
  const Blended blended = blend_with_mean(frame, picture, picture, picture);
  EXPECT_LT(blended.weight.pixels[0], 0.3F);
  EXPECT_GT(blended.weight.pixels[firefly], 0.99F);
  EXPECT_LT(blended.picture.pixels[firefly], 2 * kTruth);
}

TEST(Blend, WithoutNoiseTheMeanIsTheResult) {
  Frame frame = exponential_frame(4);
  for (int s = 0; s < 4; ++s)
    for (int c = 0; c < 3; ++c) std::fill_n(frame.plane(s, kRadianceOffset + c), frame.plane_size(), 0.25F);
  const Image wrong = constant(7);
  const Blended blended = blend_with_mean(frame, wrong, wrong, wrong);
  for (const float value : blended.picture.pixels) ASSERT_EQ(value, 0.25F);
}

TEST(Blend, HalvesHaveEveryOtherSample) {
  const Frame frame = random_frame(7, 5, 5, 9);
  const Frame first = half_of(frame, 0), second = half_of(frame, 1);
  ASSERT_EQ(first.spp, 3);
  ASSERT_EQ(second.spp, 2);
  EXPECT_EQ(first.plane(2, 3)[11], frame.plane(4, 3)[11]);
  EXPECT_EQ(second.plane(1, kRadianceOffset)[20], frame.plane(3, kRadianceOffset)[20]);
  EXPECT_EQ(second.valid_plane(0)[4], frame.valid_plane(1)[4]);
  EXPECT_EQ(first.info.depth_scale, frame.info.depth_scale);
}

TEST(Blend, HalvesInPlaceGiveTheSameBits) {
  Frame frame = random_frame(31, 17, 5, 9);
  for (size_t i = 3; i < frame.valid.size(); i += 5) frame.valid[i] = 0;
  sanitise(frame);
  frame.info.depth_scale = 2;
  DenoiseOptions one;
  one.threads = 1;
  for (const char* name : {"common_fast", "means"}) {
    const Denoiser denoiser(resolve_model(name));
    for (const int first : {0, 1}) {
      const HalfInPlace half = half_in_place(frame, first, denoiser.network_config().features);
      EXPECT_EQ(denoiser.denoise_parts(half.arrays, one).picture.pixels,
                denoiser.denoise(half_of(frame, first), one).pixels)
          << name << " " << first;
    }
  }
}

// The bits are those without a budget, and the smallest one that the error names is enough.
TEST(Blend, StaysWithinAMemoryBudget) {
  const TemporaryFolder folder;
  write_frame(folder / "in.exr", random_frame(211, 120, 6, 9));
  DenoiseJob job;
  job.model = resolve_model("common_fast");
  job.threads = 1;
  job.blend = true;
  job.tasks = plan_tasks({(folder / "in.exr").string()}, (folder / "free.exr").string(), std::nullopt, false);
  run_denoise_job(job);
  job.tasks[0].output = folder / "bounded.exr";
  job.max_memory_bytes = 1 << 20;
  std::string refusal;
  try {
    run_denoise_job(job);
  } catch (const UsageError& error) {
    refusal = error.what();
  }
  std::smatch smallest;
  ASSERT_TRUE(std::regex_search(refusal, smallest, std::regex("at 6 samples.*smallest is ([0-9]+) MB")))
      << refusal;
  job.max_memory_bytes = (std::stoll(smallest[1]) + 2) << 20;  // for what the error itself has taken
  run_denoise_job(job);
  EXPECT_EQ(read_image(folder / "bounded.exr").pixels, read_image(folder / "free.exr").pixels);
}

TEST(Blend, IsFiniteAndBetweenItsTwoPicturesAtTheExtremes) {
  for (const float value : {0.0F, 1e-40F, 1e-38F, 65504.0F, 3e38F})
    for (const float denoised : {0.0F, 1e-38F, 3e38F}) {
      Frame frame = random_frame(5, 3, 3, 2);
      for (int s = 0; s < 3; ++s)
        for (int c = 0; c < 3; ++c)
          std::fill_n(frame.plane(s, kRadianceOffset + c), frame.plane_size(), s == 1 ? value : 0.5F * value);
      std::fill(frame.valid.begin(), frame.valid.end(), uint8_t{1});
      frame.valid_plane(1)[3] = frame.valid_plane(0)[3] = frame.valid_plane(2)[3] = 0;
      Image picture(5, 3, 3);
      std::fill(picture.pixels.begin(), picture.pixels.end(), denoised);
      const Blended blended = blend_with_mean(frame, picture, picture, picture);
      const Image mean = mean_radiance(frame);
      for (size_t i = 0; i < picture.pixels.size(); ++i) {
        const double low = std::min(mean.pixels[i], denoised), high = std::max(mean.pixels[i], denoised);
        ASSERT_GE(blended.picture.pixels[i], low * (1 - 1e-6)) << value << " and " << denoised;
        ASSERT_LE(blended.picture.pixels[i], high * (1 + 1e-6)) << value << " and " << denoised;
      }
    }
}

TEST(Blend, OneSampleAndOtherSizesAreRefused) {
  const Image picture = constant(1);
  EXPECT_FALSE(can_blend(exponential_frame(1)));
  EXPECT_ERROR(blend_with_mean(exponential_frame(1), picture, picture, picture), "two samples");
  EXPECT_ERROR(blend_with_mean(exponential_frame(1), picture, picture, picture), "found 1");
  EXPECT_ERROR(blend_with_mean(exponential_frame(2), Image(3, 3, 3), picture, picture), "3x3");
  EXPECT_ERROR(blend_with_mean(exponential_frame(2), Image(3, 3, 3), picture, picture), "32x32");
}

}  // namespace
}  // namespace ld
