// `ld_denoise --filter` as the program runs it.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "frame/frame_file.h"
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
  void write_walk(const std::vector<int>& numbers) const {
    for (const int number : numbers) {
      Frame frame = random_frame(24, 18, 1, uint32_t(number));
      frame.features.emplace_back("flow");
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        for (int c = kNormalOffset; c < kDepthOffset; ++c)
          frame.plane(0, c)[p] = c == kNormalOffset + 2 ? 1 : 0;
        frame.plane(0, kDepthOffset)[p] = 4;
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
