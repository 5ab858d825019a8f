// `ld_denoise --skip-within` as programs and the library run it, with released weights.
#include <gtest/gtest.h>

#include <cmath>

#include "frame/frame_file.h"
#include "inference/denoise_job.h"
#include "inference/denoiser.h"
#include "models/network_config.h"
#include "tests/support/random_frame.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

const std::filesystem::path kModel =
    std::filesystem::path(LD_SOURCE_DIR) / "models/pretrained/common_fast.safetensors";

/// Noise before a background of one colour, which holds no surface.
Frame before_background(int width, int height, int spp) {
  Frame frame = random_frame(width, height, spp, 4);
  for (int s = 0; s < spp; ++s)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < 3 * width / 4; ++x)
        for (int c = 0; c < kSampleChannels; ++c)
          frame.plane(s, c)[size_t(y) * size_t(width) + size_t(x)] = c < 3 ? 0.25F * float(c + 1) : 0.0F;
  sanitise(frame);
  frame.info.depth_scale = 2;
  return frame;
}

Image denoised(const Frame& frame, std::optional<double> within, int threads = 2, int64_t budget = 0) {
  DenoiseOptions options;
  options.threads = threads;
  options.skip_within = within;
  options.max_memory_bytes = budget;
  return Denoiser(kModel).denoise(frame, options);
}

/// |a - b| / (1 + |b|), the largest.
double difference(const Image& a, const Image& b) {
  double largest = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i)
    largest = std::max(
        largest, std::fabs(double(a.pixels[i]) - double(b.pixels[i])) / (1 + std::fabs(double(b.pixels[i]))));
  return largest;
}

TEST(SkipWithin, KeepsItsBoundAndAtZeroEveryBit) {
  const Frame frame = before_background(167, 53, 3);
  const Image all = denoised(frame, std::nullopt);
  EXPECT_EQ(denoised(frame, 0).pixels, all.pixels);
  const Image left_out = denoised(frame, 1e-4);
  EXPECT_NE(left_out.pixels, all.pixels);
  EXPECT_LE(difference(left_out, all), 1e-4);
}

TEST(SkipWithin, DependsOnNeitherThreadsNorMemory) {
  const Frame frame = before_background(167, 53, 3);
  const Image expected = denoised(frame, 1e-4);
  EXPECT_EQ(denoised(frame, 1e-4, 1).pixels, expected.pixels);
  const int64_t least = Denoiser(kModel).least_memory_bytes(frame.width, frame.height, frame.spp);
  EXPECT_EQ(denoised(frame, 1e-4, 1, least + (int64_t{8} << 20)).pixels, expected.pixels);
}

TEST(SkipWithin, TakesSamplesWhereTheyLie) {
  const Denoiser denoiser(kModel);
  const Frame frame = before_background(167, 53, 3);
  SampleArrays arrays;
  arrays.width = frame.width;
  arrays.height = frame.height;
  arrays.spp = frame.spp;
  arrays.depth_scale = frame.info.depth_scale;
  const auto plane = ptrdiff_t(frame.plane_size());
  for (const std::string& name : denoiser.network_config().features) {
    const Feature& feature = find_feature(name);
    arrays.features.push_back(
        {&feature, {frame.plane(0, feature.offset), plane * frame.channels, plane, frame.width, 1}});
  }
  DenoiseOptions options;
  options.threads = 2;
  options.skip_within = 1e-4;
  EXPECT_EQ(denoiser.denoise_parts(arrays, options).picture.pixels, denoised(frame, 1e-4).pixels);
  EXPECT_GT(denoiser.skipped().pixels, 0.5);
}

TEST(SkipWithin, PartsOfTheLightKeepTheBound) {
  Frame frame = before_background(167, 53, 3);
  frame.add_part("lamp");
  frame.alpha.assign(frame.valid.size(), 0.75F);
  for (int s = 0; s < frame.spp; ++s)
    for (int c = 0; c < 3; ++c)
      for (size_t p = 0; p < frame.plane_size(); ++p)
        frame.part_plane(0, s, c)[p] = c == 0 ? -0.5F : 0.25F * frame.plane(s, c)[p];
  const Denoiser denoiser(kModel);
  DenoiseOptions options;
  options.threads = 2;
  options.skip_within = std::nullopt;
  const DenoisedParts all = denoiser.denoise_parts(frame, /*alpha=*/true, options);
  options.skip_within = 1e-4;
  const DenoisedParts left_out = denoiser.denoise_parts(frame, /*alpha=*/true, options);
  EXPECT_GT(denoiser.skipped().pixels, 0.5);
  EXPECT_LE(difference(left_out.picture, all.picture), 1e-4);
  EXPECT_LE(difference(left_out.parts[0], all.parts[0]), 1e-4);
  EXPECT_LE(difference(left_out.alpha, all.alpha), 1e-4);
}

TEST(SkipWithin, IsReported) {
  const TemporaryFolder folder;
  write_frame(folder / "a.exr", before_background(167, 53, 3));
  DenoiseJob job;
  job.model = kModel;
  job.tasks = plan_tasks({(folder / "a.exr").string()}, (folder / "b.exr").string(), std::nullopt, false);
  EXPECT_GT(run_denoise_job(job).frames[0]["skipped"]["pixels"], 0.5);
  job.skip_within = std::nullopt;
  EXPECT_EQ(run_denoise_job(job).frames[0]["skipped"]["pixels"], 0);
}

TEST(SkipWithin, WhatIsNoBoundIsAWrongCommandLine) {
  for (const std::string text : {"-1", "2", "nan", "1e-4x", "", "on"}) {
    const ProgramResult result =
        run_program("ld_denoise", {"--skip-within=" + text, "a.exr", "--output", "b.exr"});
    EXPECT_EQ(result.exit_code, 2) << text;
  }
  expect_failure(run_program("ld_denoise", {"--filter=eaw", "--skip-within=0", "a.exr", "--output", "b.exr"}),
                 2, {"--skip-within goes with models", "eaw"});
}

}  // namespace
}  // namespace ld
