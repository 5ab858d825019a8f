// The C interface against the class that it wraps, and what it says to wrong calls.
#include <gtest/gtest.h>

#ifdef __SSE__
#include <xmmintrin.h>
#endif

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <limits>
#include <regex>
#include <string>
#include <thread>
#include <vector>

#include "filters/frame_filter.h"
#include "inference/denoiser.h"
#include "layered_denoiser/layered_denoiser.hpp"
#include "tests/support/random_frame.h"
#include "tests/support/sanitized.h"

namespace ld {
namespace {

const std::filesystem::path kWeights =
    std::filesystem::path(LD_SOURCE_DIR) / "tests/fixtures/before_simd/layer.safetensors";

/// All samples of one feature of a frame, [spp][channels][height][width].
std::vector<float> samples_of(const Frame& frame, const std::string& name) {
  const Feature& feature = find_feature(name);
  std::vector<float> data;
  for (int s = 0; s < frame.spp; ++s)
    data.insert(data.end(), frame.plane(s, feature.offset),
                frame.plane(s, feature.offset) + size_t(feature.channels) * frame.plane_size());
  return data;
}

/// What the library must give: it promises the bits of the class that it wraps for as many threads, here one.
std::vector<float> expected_picture(const std::filesystem::path& weights, const Frame& frame) {
  DenoiseOptions one;
  one.threads = 1;
  return Denoiser(weights).denoise(frame, one).pixels;
}

class Embed : public ::testing::Test {
 protected:
  Embed() : denoiser_(kWeights.string()), frame_(random_frame(13, 9, 3)) {
    ld_set_threads(1);
    denoiser_.set_size(frame_.width, frame_.height, frame_.spp);
    for (const auto& [name, channels] : denoiser_.features()) buffers_.push_back(samples_of(frame_, name));
  }
  void set_all() {
    for (size_t i = 0; i < buffers_.size(); ++i)
      denoiser_.set_feature(denoiser_.features()[i].name, buffers_[i].data());
  }
  std::vector<float> denoise() {
    std::vector<float> picture(3 * frame_.plane_size(), -1);
    denoiser_.denoise(picture.data());
    return picture;
  }
  /// The error of a call that must fail.
  std::string failure(LdStatus expected, const std::function<void()>& call) {
    try {
      call();
    } catch (const layered_denoiser::Failure& failure) {
      EXPECT_EQ(failure.status(), expected);
      return failure.what();
    }
    ADD_FAILURE() << "the call succeeded";
    return "";
  }

  layered_denoiser::Denoiser denoiser_;
  Frame frame_;
  std::vector<std::vector<float>> buffers_;
};

TEST_F(Embed, PartsOfTheLightSumToThePictureAndLeaveItsBits) {
  set_all();
  const std::vector<float> expected = denoise();
  const std::vector<float> light = samples_of(frame_, "radiance");
  std::vector<float> parts[2] = {light, light}, pictures[2];
  for (size_t i = 0; i < light.size(); ++i) {
    parts[0][i] = light[i] * 1.25F * float(i % 7) / 6;
    parts[1][i] = light[i] - parts[0][i];
  }
  for (int i = 0; i < 2; ++i) {
    pictures[i].resize(expected.size());
    denoiser_.add_part(parts[i].data(), pictures[i].data());
  }
  std::vector<float> alpha(frame_.valid.size(), 1), filtered(2 * frame_.plane_size(), -1);
  const LdStrides every_other = {0, 0, 2 * frame_.width, 2};
  denoiser_.set_alpha(alpha.data(), filtered.data(), nullptr, &every_other);
  EXPECT_EQ(denoise(), expected);
  const float largest = *std::max_element(expected.begin(), expected.end());
  for (size_t i = 0; i < expected.size(); ++i)
    ASSERT_NEAR(pictures[0][i] + pictures[1][i], expected[i], 1e-5F * largest);
  for (size_t p = 0; p < frame_.plane_size(); ++p) {
    ASSERT_NEAR(filtered[2 * p], 1, 1e-6F);
    ASSERT_EQ(filtered[2 * p + 1], -1) << "what lies between is the caller's";
  }
  denoiser_.set_size(frame_.width, frame_.height, frame_.spp);
  std::fill(pictures[0].begin(), pictures[0].end(), -1.0F);
  set_all();
  denoise();
  EXPECT_EQ(pictures[0], std::vector<float>(expected.size(), -1)) << "a new size forgets the parts";
}

TEST_F(Embed, WrongPartsOfTheLight) {
  std::vector<float> data(1);
  EXPECT_NE(failure(LD_INVALID_ARGUMENT, [&] { denoiser_.add_part(nullptr, data.data()); })
                .find("samples of a part of the light are a null pointer"),
            std::string::npos);
  EXPECT_NE(failure(LD_INVALID_ARGUMENT, [&] { denoiser_.set_alpha(data.data(), nullptr); })
                .find("picture to write of alpha is a null pointer"),
            std::string::npos);
  layered_denoiser::Denoiser fresh(kWeights.string());
  EXPECT_NE(failure(LD_INVALID_ARGUMENT, [&] { fresh.add_part(data.data(), data.data()); })
                .find("a part of the light was set before the size"),
            std::string::npos);
  EXPECT_EQ(ld_add_part(nullptr, data.data(), nullptr, data.data(), nullptr), LD_INVALID_ARGUMENT);
  EXPECT_EQ(ld_set_alpha(nullptr, data.data(), nullptr, data.data(), nullptr), LD_INVALID_ARGUMENT);
}

TEST_F(Embed, GivesThePictureOfTheDenoiserBitForBit) {
  set_all();
  EXPECT_EQ(denoise(), expected_picture(kWeights, frame_));
}

TEST_F(Embed, TakesAnyLayout) {
  set_all();
  const std::vector<float> expected = denoise();
  // Samples of a pixel side by side, each with its channels; the picture likewise.
  const ptrdiff_t width = frame_.width, height = frame_.height, spp = frame_.spp;
  std::vector<std::vector<float>> interleaved;
  for (size_t i = 0; i < buffers_.size(); ++i) {
    const auto [name, channels] = denoiser_.features()[i];
    const LdStrides strides = {channels, 1, width * spp * channels, spp * channels};
    std::vector<float>& data = interleaved.emplace_back(buffers_[i].size());
    const float* from = buffers_[i].data();
    for (ptrdiff_t s = 0; s < spp; ++s)
      for (ptrdiff_t c = 0; c < channels; ++c)
        for (ptrdiff_t y = 0; y < height; ++y)
          for (ptrdiff_t x = 0; x < width; ++x)
            data[size_t(s * strides.sample + c + y * strides.row + x * strides.pixel)] = *from++;
    denoiser_.set_feature(name, data.data(), &strides);
  }
  std::vector<float> picture(expected.size());
  const LdStrides rgb = {0, 1, 3 * width, 3};
  denoiser_.denoise(picture.data(), &rgb);
  for (size_t c = 0; c < 3; ++c)
    for (size_t p = 0; p < frame_.plane_size(); ++p)
      ASSERT_EQ(picture[3 * p + c], expected[c * frame_.plane_size() + p]) << p;
}

TEST_F(Embed, SamplesThatAreNotFiniteOrNotDrawnCountForNothing) {
  set_all();
  std::vector<uint8_t> valid(size_t(frame_.spp) * frame_.plane_size(), 255);
  valid[5] = 0;
  denoiser_.set_valid(valid.data());
  const std::vector<float> expected = denoise();
  for (const float value : expected) ASSERT_TRUE(std::isfinite(value));
  denoiser_.set_valid(nullptr);
  EXPECT_NE(denoise(), expected);
  for (size_t i = 0; i < buffers_.size(); ++i)
    if (denoiser_.features()[i].name == "radiance") buffers_[i][5] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_EQ(denoise(), expected);
}

TEST_F(Embed, AMemoryBoundChangesNoBitAndOneTooSmallIsRefused) {
  set_all();
  const std::vector<float> expected = denoise();
  denoiser_.set_max_memory(20000);
  EXPECT_EQ(denoise(), expected);
  denoiser_.set_max_memory(1);
  std::vector<float> picture(expected.size(), -1);
  const std::string error = failure(LD_INVALID_ARGUMENT, [&] { denoiser_.denoise(picture.data()); });
  EXPECT_EQ(picture, std::vector<float>(picture.size(), -1));
  std::smatch smallest;
  ASSERT_TRUE(std::regex_search(error, smallest, std::regex("smallest is ([0-9]+) MB"))) << error;
  if (kAddressSanitizer)
    GTEST_SKIP() << "the sanitizer keeps what is freed, so that the smallest budget grows";
  denoiser_.set_max_memory(std::stoul(smallest[1]) + 2);  // for what the message itself has taken
  EXPECT_EQ(denoise(), expected);
}

TEST(EmbedReleased, LeavesOutWorkWithinTheBoundThatWasSet) {
  ld_set_threads(1);
  const std::string weights = std::string(LD_SOURCE_DIR) + "/models/pretrained/common_fast.safetensors";
  // Noise beside a background of one colour, which fills a stretch of the rows.
  Frame frame = random_frame(167, 53, 3, 4);
  frame.features = {"radiance"};
  for (int s = 0; s < frame.spp; ++s)
    for (int c = 0; c < 3; ++c)
      for (int y = 0; y < frame.height; ++y) std::fill_n(&frame.plane(s, c)[size_t(y) * 167], 125, 0.3F);
  layered_denoiser::Denoiser denoiser(weights);
  denoiser.set_size(frame.width, frame.height, frame.spp);
  const std::vector<float> radiance = samples_of(frame, "radiance");
  denoiser.set_feature("radiance", radiance.data());
  std::vector<float> exact(3 * frame.plane_size()), left_out = exact;
  EXPECT_EQ(denoiser.skipped().pixels, 0);
  denoiser.denoise(exact.data());
  EXPECT_EQ(denoiser.skipped().pixels, 0);
  denoiser.set_skip_within(1e-3);
  denoiser.denoise(left_out.data());
  EXPECT_GT(denoiser.skipped().pixels, 0.5);
  EXPECT_NE(left_out, exact);
  for (size_t i = 0; i < exact.size(); ++i)
    ASSERT_LE(std::abs(left_out[i] - exact[i]), 1e-3 * (1 + std::abs(exact[i]))) << i;
  for (const double wrong : {-1.0, 2.0, std::numeric_limits<double>::quiet_NaN()})
    EXPECT_THROW(denoiser.set_skip_within(wrong), layered_denoiser::Failure) << wrong;
  EXPECT_EQ(ld_set_skip_within(nullptr, 0), LD_INVALID_ARGUMENT);
  EXPECT_EQ(ld_skipped(nullptr).pixels, 0);
}

TEST(EmbedReleased, WeightsDoWithoutFeaturesThatAreNotSet) {
  ld_set_threads(1);
  const std::string weights = std::string(LD_SOURCE_DIR) + "/models/pretrained/common_fast.safetensors";
  layered_denoiser::Denoiser denoiser(weights);
  Frame frame = random_frame(13, 9, 3);
  frame.features = {"radiance", "albedo"};
  denoiser.set_size(frame.width, frame.height, frame.spp);
  std::vector<std::vector<float>> buffers;
  for (const std::string& name : frame.features)
    denoiser.set_feature(name, buffers.emplace_back(samples_of(frame, name)).data());
  std::vector<float> picture(3 * frame.plane_size());
  denoiser.denoise(picture.data());
  // Channels of features that a frame does not hold are 0.
  for (int s = 0; s < frame.spp; ++s)
    for (const Feature& feature : feature_schema())
      if (feature.offset < frame.channels && !frame.holds(feature.name))
        std::fill_n(frame.plane(s, feature.offset), size_t(feature.channels) * frame.plane_size(), 0.0F);
  EXPECT_EQ(picture, expected_picture(weights, frame));
}

TEST_F(Embed, AMissingFeatureIsNamed) {
  denoiser_.set_feature("radiance", buffers_[0].data());
  const std::string error = failure(LD_INVALID_ARGUMENT, [&] { denoise(); });
  EXPECT_NE(error.find("'normal'"), std::string::npos) << error;
  EXPECT_NE(error.find("ld_set_feature"), std::string::npos) << error;
}

TEST_F(Embed, WrongCallsSayWhatIsWrong) {
  EXPECT_NE(failure(LD_INVALID_ARGUMENT, [&] { denoiser_.set_feature("albdo", buffers_[0].data()); })
                .find("did you mean 'albedo'"),
            std::string::npos);
  EXPECT_NE(failure(LD_INVALID_ARGUMENT, [&] { denoiser_.set_feature("radiance", nullptr); }).find("null"),
            std::string::npos);
  EXPECT_NE(failure(LD_INVALID_ARGUMENT, [&] { denoiser_.set_size(0, 4, 1); }).find("0x4"),
            std::string::npos);
  EXPECT_NE(failure(LD_INVALID_ARGUMENT, [&] { denoiser_.set_size(2000000, 2000000, 8); }).find("1000 GB"),
            std::string::npos);
  EXPECT_NE(failure(LD_FAILED, [] { layered_denoiser::Denoiser("/nowhere/w.safetensors"); })
                .find("/nowhere/w.safetensors"),
            std::string::npos);
  EXPECT_EQ(ld_set_threads(-1), LD_INVALID_ARGUMENT);
  EXPECT_EQ(ld_create(nullptr, nullptr), LD_INVALID_ARGUMENT);
  EXPECT_EQ(ld_denoise(nullptr, nullptr, nullptr), LD_INVALID_ARGUMENT);
  EXPECT_NE(std::string(ld_error()).find("null"), std::string::npos);
  EXPECT_EQ(ld_feature_count(nullptr), 0);
  EXPECT_EQ(ld_feature_name(nullptr, 0), nullptr);
  ld_destroy(nullptr);
}

TEST_F(Embed, ACancelledCallLeavesThePictureAlone) {
  set_all();
  denoiser_.set_progress([](double) { return false; });
  std::vector<float> picture(3 * frame_.plane_size(), -1);
  failure(LD_CANCELLED, [&] { denoiser_.denoise(picture.data()); });
  EXPECT_EQ(picture, std::vector<float>(picture.size(), -1));
  double largest = 0;
  denoiser_.set_progress([&](double share) {
    largest = std::max(largest, share);
    return true;
  });
  denoiser_.denoise(picture.data());
  EXPECT_EQ(largest, 1);
}

#ifdef __SSE__
TEST_F(Embed, TheCallersFloatingPointSettingsComeBack) {
  set_all();
  const std::vector<float> expected = denoise();
  std::vector<float> picture(expected.size());
  const unsigned before = _mm_getcsr(), plain = 0x1f80;
  const unsigned flush = plain | 0x8040, upward = plain | 0x4000, trapping = plain & ~0x0680U;
  for (const unsigned settings : {plain, flush, upward, trapping, plain | 0x0001}) {
    SCOPED_TRACE(settings);
    const auto comes_back = [&](LdStatus status, const std::function<LdStatus()>& call) {
      _mm_setcsr(settings);
      const LdStatus found = call();
      const unsigned after = _mm_getcsr();
      _mm_setcsr(before);
      EXPECT_EQ(found, status) << ld_error();
      EXPECT_EQ(after, settings);
    };
    LdDenoiser* denoiser = nullptr;
    comes_back(LD_FAILED, [&] { return ld_create("/nowhere/w.safetensors", &denoiser); });
    comes_back(LD_OK, [&] { return ld_create(kWeights.c_str(), &denoiser); });
    comes_back(LD_INVALID_ARGUMENT, [&] { return ld_set_size(denoiser, 0, 4, 1); });
    comes_back(LD_OK, [&] { return ld_set_size(denoiser, frame_.width, frame_.height, frame_.spp); });
    comes_back(LD_INVALID_ARGUMENT, [&] { return ld_denoise(denoiser, picture.data(), nullptr); });
    for (size_t i = 0; i < buffers_.size(); ++i)
      comes_back(LD_OK, [&] {
        return ld_set_feature(denoiser, ld_feature_name(denoiser, int(i)), buffers_[i].data(), nullptr);
      });
    unsigned seen = 0;  // what the caller's own function finds
    const LdProgress stop = [](double, void* user) {
      *static_cast<unsigned*>(user) = _mm_getcsr();
      return 0;
    };
    ld_set_progress(denoiser, stop, &seen);
    comes_back(LD_CANCELLED, [&] { return ld_denoise(denoiser, picture.data(), nullptr); });
    EXPECT_EQ(seen, settings);
    ld_set_progress(denoiser, nullptr, nullptr);
    comes_back(LD_OK, [&] { return ld_denoise(denoiser, picture.data(), nullptr); });
    EXPECT_EQ(picture, expected) << "the caller's settings change no bit of the picture";
    ld_destroy(denoiser);
  }
}
#endif

TEST(EmbedFilter, GivesThePicturesOfTheFilterOverASequenceBitForBit) {
  ld_set_threads(1);
  auto denoiser = layered_denoiser::Denoiser::filter("svgf", {"levels=3"});
  FrameFilter filter({"svgf", "svgf", {"levels=3"}});
  SequenceState state;
  Frame frame = random_frame(13, 9, 1);
  denoiser.set_size(frame.width, frame.height, frame.spp);
  const auto next = [&](int64_t position) {
    std::vector<std::vector<float>> buffers;
    for (const auto& [name, channels] : denoiser.features())
      if (find_feature(name).offset + channels <= kSampleChannels) {
        buffers.push_back(samples_of(frame, name));
        denoiser.set_feature(name, buffers.back().data());
      }
    std::vector<float> picture(3 * frame.plane_size());
    // A refusal leaves the history as it is.
    denoiser.set_max_memory(1000);
    EXPECT_THROW(denoiser.denoise(picture.data()), layered_denoiser::Failure);
    denoiser.set_max_memory(0);
    denoiser.denoise(picture.data());
    Frame same = frame;
    same.features = {"radiance", "normal", "depth", "albedo", "specular", "flow"};
    same.info.depth_scale = median_depth(same);
    state.advance(SequencePlace{0, position}, frame.width, frame.height);
    EXPECT_EQ(picture, filter.denoise(same, state, 1).pixels) << position;
    for (float& value : frame.samples) value *= 0.5F;
  };
  for (const int64_t position : {0, 1, 2}) next(position);
  denoiser.restart();
  state.end();
  for (const int64_t position : {3, 4}) next(position);
}

TEST(EmbedFilter, RefusesWhatIsNone) {
  LdDenoiser* denoiser = nullptr;
  EXPECT_EQ(ld_create_filter("bilateral", nullptr, &denoiser), LD_INVALID_ARGUMENT);
  EXPECT_EQ(ld_create_filter(nullptr, nullptr, &denoiser), LD_INVALID_ARGUMENT);
  EXPECT_EQ(ld_create_filter("eaw", nullptr, nullptr), LD_INVALID_ARGUMENT);
  const char* settings[] = {"sigma=1", nullptr};
  EXPECT_EQ(ld_create_filter("eaw", settings, &denoiser), LD_INVALID_ARGUMENT);
  EXPECT_EQ(ld_create_filter("soft=eaw", nullptr, &denoiser), LD_INVALID_ARGUMENT);
  EXPECT_EQ(denoiser, nullptr);
  EXPECT_EQ(ld_restart(nullptr), LD_INVALID_ARGUMENT);
  EXPECT_EQ(ld_set_camera(nullptr, nullptr, nullptr), LD_INVALID_ARGUMENT);
}

TEST_F(Embed, ThreadsMayBeSetWhileAnotherThreadDenoises) {
  set_all();
  const std::vector<float> expected = denoise();
  std::atomic<bool> done{false};
  std::thread other([&] {
    while (!done) ld_set_threads(1);  // the tools that watch for races see these writes
  });
  const std::vector<float> picture = denoise();
  done = true;
  other.join();
  EXPECT_EQ(picture, expected);
}

}  // namespace
}  // namespace ld
