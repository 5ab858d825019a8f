// Models that remember, over the files of a sequence.
#include <fmt/format.h>

#include "frame/frame_file.h"
#include "inference/denoise_job.h"
#include "inference/denoiser.h"
#include "layered_denoiser/layered_denoiser.hpp"
#include "tests/inference/denoising_test.h"
#include "tests/support/expect_error.h"
#include "tests/support/moving_frame.h"

namespace ld {
namespace {

DenoiseOptions on_two_threads() {
  DenoiseOptions options;
  options.threads = 2;
  return options;
}

NetworkConfig history_model() {
  NetworkConfig config = small_config();
  config.name = "layer_history";
  config.features = {"radiance", "depth", "normal", "albedo", "flow"};
  config.demodulation = "albedo";
  return config;
}

NetworkConfig recurrent_model() {
  NetworkConfig config = small_recurrent_config();
  config.optional = {"emission"};  // which these frames lack
  return config;
}

/// By the names of their networks.
class RememberingModel : public DenoisingTest, public ::testing::WithParamInterface<std::string> {
 protected:
  void SetUp() override {
    const NetworkConfig config = GetParam() == "recurrent" ? recurrent_model() : history_model();
    save_network(model_, *small_network(config, torch::kFloat32), "{}", DType::f32);
  }

  static std::string file(const std::string& name, int number) {
    return path(fmt::format("{}.{}.exr", name, number));
  }

  void write_frames(const std::vector<int>& numbers) const {
    for (const int number : numbers)
      write_frame(file("walk", number), moving_frame(24, 18, 2, uint32_t(number)));
  }

  DenoiseReport denoise(const std::string& input, const std::string& output) const {
    DenoiseJob job;
    job.model = model_;
    job.tasks = plan_tasks({path(input)}, path(output), std::nullopt, false);
    job.full_float = true;
    job.threads = 1;
    return run_denoise_job(job);
  }

  static std::vector<float> pixels(const std::string& picture) { return read_image(picture).pixels; }

  std::string model_ = path("remembering.safetensors");
};

TEST_P(RememberingModel, CarriesItsStateOverASequenceAndBeginsAnewAtAHole) {
  write_frames({1, 2, 3, 5, 6});
  const DenoiseReport report = denoise("walk.#.exr", "out.#.exr");
  EXPECT_TRUE(report.failed.empty());
  const Denoiser denoiser(model_);
  SequenceState state;
  for (const int number : {1, 2, 3, 5, 6}) {
    Faults faults;
    const Frame frame = read_frame(file("walk", number), denoiser.features(), faults);
    state.advance(SequencePlace{0, number}, frame.width, frame.height);
    EXPECT_EQ(pixels(file("out", number)), denoiser.denoise(frame, on_two_threads(), &state).pixels)
        << number;
    denoise(fmt::format("walk.{}.exr", number), fmt::format("alone.{}.exr", number));
    EXPECT_EQ(pixels(file("out", number)) == pixels(file("alone", number)), number == 1 || number == 5)
        << number;
    EXPECT_EQ(pixels(file("alone", number)), denoiser.denoise(frame, on_two_threads()).pixels) << number;
  }
}

TEST_P(RememberingModel, TheLibraryCarriesItsStateUntilARestart) {
  ld_set_threads(2);
  layered_denoiser::Denoiser library(model_);
  EXPECT_TRUE(library.remembers());
  library.set_size(24, 18, 2);
  const Denoiser denoiser(model_);
  SequenceState state;
  for (int number = 0; number < 5; ++number) {
    const Frame frame = moving_frame(24, 18, 2, uint32_t(number));
    if (number == 3) {
      library.restart();
      state.end();
    }
    std::vector<std::vector<float>> buffers;
    for (const auto& [name, channels] : library.features()) {
      if (!frame.holds(name)) continue;
      std::vector<float>& samples = buffers.emplace_back();
      for (int s = 0; s < frame.spp; ++s) {
        const float* const plane = frame.plane(s, find_feature(name).offset);
        samples.insert(samples.end(), plane, plane + size_t(channels) * frame.plane_size());
      }
      library.set_feature(name, samples.data());
    }
    std::vector<float> picture(3 * frame.plane_size());
    library.denoise(picture.data());
    Frame same = frame;
    same.info.depth_scale = median_depth(frame);
    state.advance(SequencePlace{0, number}, 24, 18);
    EXPECT_EQ(picture, denoiser.denoise(same, on_two_threads(), &state).pixels) << number;
    EXPECT_EQ(picture == denoiser.denoise(same, on_two_threads()).pixels, number == 0 || number == 3)
        << number;
  }
}

TEST_P(RememberingModel, HalvesWithTheStatePassedOnAreTheWhole) {
  const Denoiser whole(model_), first(model_), second(model_);
  SequenceState one, passed;
  for (int number = 0; number < 6; ++number) {
    const Frame frame = moving_frame(24, 18, 2, uint32_t(number));
    one.advance(SequencePlace{0, number}, 24, 18);
    passed.advance(SequencePlace{0, number}, 24, 18);
    const Denoiser& other = number < 3 ? first : second;
    EXPECT_EQ(whole.denoise(frame, {}, &one).pixels, other.denoise(frame, {}, &passed).pixels) << number;
  }
}

// A network without a filter cannot tell parts of the light apart.
TEST_P(RememberingModel, PartsOfTheLightNeedAFilter) {
  Frame frame = moving_frame(24, 18, 2, 0);
  frame.add_part("part");
  if (GetParam() == "recurrent") {
    EXPECT_ERROR(Denoiser(model_).denoise_parts(frame, false), "cannot filter parts of it");
  } else {
    EXPECT_NO_THROW(Denoiser(model_).denoise_parts(frame, false));
  }
}

INSTANTIATE_TEST_SUITE_P(Networks, RememberingModel, ::testing::Values("layer_history", "recurrent"),
                         [](const auto& network) { return network.param; });

class RememberingParts : public RememberingModel {};

// What parts of the light come to is what the picture comes to, with their history as well.
TEST_P(RememberingParts, HaveTheHistoryOfTheWhole) {
  const Denoiser denoiser(model_);
  SequenceState state, plain;
  for (int number = 0; number < 4; ++number) {
    Frame frame = moving_frame(24, 18, 2, uint32_t(number));
    plain.advance(SequencePlace{0, number}, 24, 18);
    const Image expected = denoiser.denoise(frame, {}, &plain);
    for (size_t part = 0; part < 2; ++part) {
      frame.add_part(fmt::format("part{}", part));
      for (int s = 0; s < frame.spp; ++s)
        for (int c = 0; c < 3; ++c)
          for (size_t p = 0; p < frame.plane_size(); ++p)
            frame.part_plane(part, s, c)[p] = (part == 0 ? 0.25F : 0.75F) * frame.plane(s, c)[p];
    }
    state.advance(SequencePlace{0, number}, 24, 18);
    const DenoisedParts found = denoiser.denoise_parts(frame, false, {}, &state);
    EXPECT_EQ(found.picture.pixels, expected.pixels) << number;
    for (size_t i = 0; i < expected.pixels.size(); ++i)
      ASSERT_NEAR(found.parts[0].pixels[i] + found.parts[1].pixels[i], expected.pixels[i],
                  1e-4 * (1 + expected.pixels[i]));
  }
}

INSTANTIATE_TEST_SUITE_P(Networks, RememberingParts, ::testing::Values("layer_history"),
                         [](const auto& network) { return network.param; });

}  // namespace
}  // namespace ld
