// `ld_denoise --filter` as the program runs it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "frame/frame_file.h"
#include "inference/blend.h"
#include "inference/denoise_job.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

class FilterJob : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  /// Frames walk.N.exr of a camera that stands still.
  void write_walk(const std::vector<int>& numbers, int spp = 1) const {
    for (const int number : numbers) {
      Frame frame = random_frame(24, 18, spp, uint32_t(number));
      frame.features.emplace_back("flow");
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        for (int s = 0; s < spp; ++s) {
          for (int c = kNormalOffset; c < kDepthOffset; ++c)
            frame.plane(s, c)[p] = c == kNormalOffset + 2 ? 1 : 0;
          frame.plane(s, kDepthOffset)[p] = 4;
        }
      }
      frame.info.depth_scale = 4;
      write_frame(path(fmt::format("walk.{}.exr", number)), frame);
    }
  }

  DenoiseJob job(const std::string& kind, const std::string& input, const std::string& output) const {
    DenoiseJob made;
    made.filter = FilterArgument{kind, kind, {}};
    made.tasks = plan_tasks({path(input)}, path(output), std::nullopt, false);
    made.full_float = true;
    made.threads = 1;
    return made;
  }

  static std::vector<float> pixels(const std::string& file) { return read_image(file).pixels; }

  TemporaryFolder folder_;
};

TEST_F(FilterJob, DenoisesEveryFrameOfASequenceAndRestartsAtAHole) {
  write_walk({1, 2, 3, 5, 6});
  for (const std::string kind : {"eaw", "svgf"}) {
    const DenoiseReport report = run_denoise_job(job(kind, "walk.#.exr", kind + ".#.exr"));
    EXPECT_TRUE(report.failed.empty());
    FrameFilter filter({kind, kind, {}});
    SequenceState state;
    for (const int number : {1, 2, 3, 5, 6}) {
      Faults faults;
      const Frame frame = read_frame(path(fmt::format("walk.{}.exr", number)), {"radiance"}, faults);
      state.advance(SequencePlace{0, number}, frame.width, frame.height);
      EXPECT_EQ(pixels(path(fmt::format("{}.{}.exr", kind, number))), filter.denoise(frame, state, 2).pixels)
          << kind << number;
    }
    run_denoise_job(job(kind, "walk.5.exr", "alone.5.exr"));
    EXPECT_EQ(pixels(path(kind + ".5.exr")), pixels(path("alone.5.exr"))) << "4 is missing";
    run_denoise_job(job(kind, "walk.6.exr", "alone.6.exr"));
    EXPECT_EQ(pixels(path(kind + ".6.exr")) == pixels(path("alone.6.exr")), kind == "eaw");
  }
}

TEST_F(FilterJob, BlendsByHalvesThatHaveAMemoryOfTheirOwn) {
  write_walk({1, 2, 3}, 64);
  for (const std::string kind : {"eaw", "svgf"}) {
    DenoiseJob blending = job(kind, "walk.#.exr", kind + ".#.exr");
    blending.blend = true;
    EXPECT_TRUE(run_denoise_job(blending).failed.empty());
    FrameFilter filter({kind, kind, {}});
    SequenceState whole, first, second;
    for (const int number : {1, 2, 3}) {
      Faults faults;
      const Frame frame = read_frame(path(fmt::format("walk.{}.exr", number)), {"radiance"}, faults);
      const auto denoised = [&](const Frame& of, SequenceState& state) {
        state.advance(SequencePlace{0, number}, frame.width, frame.height);
        return filter.denoise(of, state, 1);
      };
      const Image picture = denoised(frame, whole);
      const Blended blended = blend_with_mean(frame, picture, denoised(half_of(frame, 0), first),
                                              denoised(half_of(frame, 1), second));
      EXPECT_EQ(pixels(path(fmt::format("{}.{}.exr", kind, number))), blended.picture.pixels);
      EXPECT_NE(picture.pixels, blended.picture.pixels);
    }
  }
}

TEST_F(FilterJob, BlendingLeavesOneSampleAloneAndGoesWithThePictureAlone) {
  write_walk({1});
  DenoiseJob blending = job("eaw", "walk.1.exr", "blended.exr");
  blending.blend = true;
  run_denoise_job(blending);
  run_denoise_job(job("eaw", "walk.1.exr", "plain.exr"));
  EXPECT_EQ(pixels(path("blended.exr")), pixels(path("plain.exr")));
  blending.layers = true;
  EXPECT_ERROR(run_denoise_job(blending), "--blend goes with the picture alone");
}

TEST_F(FilterJob, RefusesWhatGoesWithModels) {
  write_walk({1});
  DenoiseJob bounded = job("eaw", "walk.1.exr", "x.exr");
  bounded.max_memory_bytes = 1 << 30;
  EXPECT_ERROR(run_denoise_job(bounded), "--max-memory goes with models");
  DenoiseJob looking = job("eaw", "walk.1.exr", "x.exr");
  looking.layers = true;
  EXPECT_ERROR(run_denoise_job(looking), "eaw is a filter");
  DenoiseJob wrong = job("svgf", "walk.1.exr", "x.exr");
  wrong.filter->assignments = {"alfa=0.1"};
  EXPECT_ERROR(run_denoise_job(wrong), "alpha");
  EXPECT_FALSE(std::filesystem::exists(path("x.exr")));
}

}  // namespace
}  // namespace ld
