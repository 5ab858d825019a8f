// Sequences forwards and backwards in time.
#include "inference/both_ways.h"

#include <fmt/format.h>

#include <fstream>
#include <limits>

#include "core/random.h"
#include "frame/frame_file.h"
#include "inference/denoise_job.h"
#include "tests/inference/denoising_test.h"
#include "tests/support/expect_error.h"
#include "tests/support/moving_frame.h"

namespace ld {
namespace {

constexpr int kFrames = 6;
constexpr float kTruth = 0.5F;

/// A wall that moves `flow_x` pixels a frame, evenly lit: all that a picture of it differs from kTruth by is
/// noise.
Frame lit_wall(uint32_t seed, float flow_x = 0) {
  Frame frame = moving_frame(20, 14, 2, 0);
  RandomStream random(seed, RandomPurpose::test);
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p) {
      for (int c = 0; c < 3; ++c) frame.plane(s, c)[p] = kTruth + random.uniform(-0.25F, 0.25F);
      for (int c = 0; c < 2; ++c) frame.plane(s, kFlowOffset + c)[p] = c == 0 ? flow_x : 0;
      frame.plane(s, kDepthOffset)[p] = 4;
    }
  frame.info.depth_scale = 4;
  return frame;
}

/// By the names of their networks.
class BothWays : public DenoisingTest, public ::testing::WithParamInterface<std::string> {
 protected:
  void SetUp() override {
    NetworkConfig config = GetParam() == "recurrent" ? small_recurrent_config() : small_config();
    config.name = GetParam();
    if (GetParam() == "recurrent")
      config.optional = {"emission"};
    else
      config.features = {"radiance", "depth", "normal", "albedo", "flow"};
    save_network(model_, *small_network(config, torch::kFloat32), "{}", DType::f32);
  }

  static std::string file(const std::string& name, int number) {
    return path(fmt::format("{}.{}.exr", name, number));
  }

  DenoiseJob job(const std::string& input, const std::string& output, bool both_ways) const {
    DenoiseJob made;
    made.model = model_;
    made.tasks = plan_tasks({path(input)}, path(output), std::nullopt, false);
    made.full_float = true;
    made.threads = 1;
    made.both_ways = both_ways;
    return made;
  }
  DenoiseReport denoise(const std::string& input, const std::string& output, bool both_ways) const {
    return run_denoise_job(job(input, output, both_ways));
  }

  static std::vector<float> pixels(const std::string& name, int number) {
    return read_image(file(name, number)).pixels;
  }
  static double error(const std::string& name, int number) {
    double sum = 0;
    const std::vector<float> all = pixels(name, number);
    for (const float value : all) sum += (value - kTruth) * (value - kTruth);
    return sum / double(all.size());
  }

  std::string model_ = path("remembering.safetensors");
};

TEST_P(BothWays, OneFrameAloneIsThePlainPicture) {
  write_frame(file("one", 1), lit_wall(1));
  denoise("one.#.exr", "one_plain.#.exr", false);
  const DenoiseReport report = denoise("one.#.exr", "one_both.#.exr", true);
  EXPECT_EQ(pixels("one_both", 1), pixels("one_plain", 1));
  EXPECT_EQ(report.frames[0]["future"], 0);
}

TEST_P(BothWays, ASequenceTurnedAroundMakesTheSamePictures) {
  for (int i = 0; i < kFrames; ++i) {
    write_frame(file("walk", i), lit_wall(uint32_t(i)));
    write_frame(file("turned", kFrames - 1 - i), lit_wall(uint32_t(i)));
  }
  denoise("walk.#.exr", "walk_both.#.exr", true);
  denoise("turned.#.exr", "turned_both.#.exr", true);
  for (int i = 0; i < kFrames; ++i)
    EXPECT_EQ(pixels("walk_both", i), pixels("turned_both", kFrames - 1 - i)) << i;
  // The last frame has no future, the others have.
  denoise("walk.#.exr", "walk_plain.#.exr", false);
  for (int i = 0; i < kFrames; ++i)
    EXPECT_EQ(pixels("walk_both", i) == pixels("walk_plain", i), i == kFrames - 1) << i;
}

TEST_P(BothWays, BeginsAnewAtAHoleAndAtACut) {
  for (const int i : {1, 2, 3, 5, 6}) write_frame(file("hole", i), lit_wall(uint32_t(i)));
  for (const int i : {1, 2, 3}) write_frame(file("first", i), lit_wall(uint32_t(i)));
  for (const int i : {5, 6}) write_frame(file("second", i), lit_wall(uint32_t(i)));
  for (const int i : {1, 2, 3, 4, 5}) {
    Frame frame = lit_wall(uint32_t(i < 4 ? i : i + 1), i == 4 ? kNoFlow : 0);
    frame.info.cut = i == 4;
    write_frame(file("cut", i), frame);
  }
  const DenoiseReport report = denoise("hole.#.exr", "hole_both.#.exr", true);
  for (const char* name : {"first", "second", "cut"})
    denoise(fmt::format("{}.#.exr", name), fmt::format("{}_both.#.exr", name), true);
  const std::vector<int64_t> history = {0, 1, 2, 0, 1}, future = {2, 1, 0, 1, 0};
  for (size_t k = 0; k < 5; ++k) {
    const int i = std::vector<int>{1, 2, 3, 5, 6}[k];
    EXPECT_EQ(pixels("hole_both", i), pixels(i < 4 ? "first_both" : "second_both", i)) << i;
    if (i < 4) {
      EXPECT_EQ(pixels("hole_both", i), pixels("cut_both", i)) << i;
    }
    EXPECT_EQ(report.frames[k]["history"], history[k]);
    EXPECT_EQ(report.frames[k]["future"], future[k]);
  }
}

TEST_P(BothWays, ADamagedFrameIsAHoleAndNothingIsLeftBehind) {
  for (const int i : {1, 2, 3}) write_frame(file("whole", i), lit_wall(uint32_t(i)));
  write_frame(file("alone", 1), lit_wall(1));
  std::ofstream(file("whole", 2)) << "no EXR";
  const DenoiseReport report = denoise("whole.#.exr", "folder/out.#.exr", true);
  EXPECT_EQ(report.failed, std::vector<std::string>{file("whole", 2)});
  denoise("alone.#.exr", "alone_both.#.exr", true);
  EXPECT_EQ(pixels("folder/out", 1), pixels("alone_both", 1));
  size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(path("folder"))) ++files;
  EXPECT_EQ(files, 2);
}

TEST_P(BothWays, RefusesWhatHasNoTwoWays) {
  write_frame(file("still", 1), lit_wall(1));
  EXPECT_ERROR(denoise("still.1.exr", "refused.exr", true), "is a still");
  DenoiseJob blending = job("still.#.exr", "refused.#.exr", true);
  blending.blend = true;
  EXPECT_ERROR(run_denoise_job(blending), "--both-ways and --blend");
  DenoiseJob forgetful = job("still.#.exr", "refused.#.exr", true);
  forgetful.model = path("model.safetensors");
  EXPECT_ERROR(run_denoise_job(forgetful), "keeps nothing from frame to frame");
  DenoiseJob filter = job("still.#.exr", "refused.#.exr", true);
  filter.filter = FilterArgument{"svgf", "svgf", {}};
  EXPECT_ERROR(run_denoise_job(filter), "goes forwards alone");
  EXPECT_FALSE(std::filesystem::exists(path("refused.exr")));
}

INSTANTIATE_TEST_SUITE_P(Networks, BothWays, ::testing::Values("layer_history", "recurrent"),
                         [](const auto& network) { return network.param; });

class BothWaysOfAHistory : public BothWays {};

TEST_P(BothWaysOfAHistory, HaveLessErrorMostOfAllTheFirstFrame) {
  for (const float flow : {0.0F, -1.0F}) {
    const std::string name = flow == 0 ? "lit" : "moved";
    for (int i = 0; i < kFrames; ++i) write_frame(file(name, i), lit_wall(uint32_t(10 + i), flow));
    denoise(name + ".#.exr", name + "_plain.#.exr", false);
    denoise(name + ".#.exr", name + "_both.#.exr", true);
    std::vector<double> share;
    for (int i = 0; i < kFrames; ++i) share.push_back(error(name + "_both", i) / error(name + "_plain", i));
    for (int i = 0; i + 1 < kFrames; ++i) {
      EXPECT_LT(share[size_t(i)], 0.95) << name << i;
      if (i > 0) {
        EXPECT_LT(share[0], share[size_t(i)]) << name << i;
      }
    }
    EXPECT_EQ(share.back(), 1) << "the last one has no future";
  }
}

INSTANTIATE_TEST_SUITE_P(Networks, BothWaysOfAHistory, ::testing::Values("layer_history"),
                         [](const auto& network) { return network.param; });

// Plain arithmetic: weights n - 1, everything that goes with a picture alike.
TEST(MixDirections, ByTheFramesOfEither) {
  const auto filled = [](int channels, float value) {
    Image image(4, 1, channels);
    std::fill(image.pixels.begin(), image.pixels.end(), value);
    return image;
  };
  DenoisedParts forwards = {filled(3, 1), {filled(3, -8)}, filled(1, 0.25F)},
                backwards = {filled(3, 2), {filled(3, 16)}, filled(1, 0.75F)};
  Image frames_forwards(4, 1, 1), frames_backwards(4, 1, 1);
  frames_forwards.pixels = {1, 4, 1, 0};  // 0: a pixel without samples
  frames_backwards.pixels = {3, 2, 1, 0};
  mix_directions(forwards, frames_forwards, backwards, frames_backwards);
  const float share[4] = {1, 0.25F, 0, 0};
  for (int p = 0; p < 4; ++p) {
    EXPECT_EQ(forwards.picture.at(2, p, 0), 1 + share[p]);
    EXPECT_EQ(forwards.parts[0].at(0, p, 0), -8 + 24 * share[p]);
    EXPECT_EQ(forwards.alpha.at(0, p, 0), 0.25F + 0.5F * share[p]);
  }
}

TEST(MixDirections, StaysBetweenTheTwo) {
  for (const float value : {0.0F, 1e-42F, 1e-38F, 65504.0F, 3e38F, std::numeric_limits<float>::max()})
    for (const float other : {0.0F, 1e-42F, 65504.0F, std::numeric_limits<float>::max()})
      for (const float n : {1.0F, 1.0000001F, 1.7F, 32.0F}) {
        Image a(1, 1, 1), b(1, 1, 1), frames(1, 1, 1), half_way(1, 1, 1);
        a.pixels = {value};
        b.pixels = {other};
        frames.pixels = {n};
        half_way.pixels = {2.3F};
        DenoisedParts forwards = {a, {}, {}};
        mix_directions(forwards, half_way, {b, {}, {}}, frames);
        EXPECT_GE(forwards.picture.pixels[0], std::min(value, other));
        EXPECT_LE(forwards.picture.pixels[0], std::max(value, other));
        if (value == other || n == 1) {
          EXPECT_EQ(forwards.picture.pixels[0], value);
        }
      }
}

}  // namespace
}  // namespace ld
