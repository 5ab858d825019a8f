// Every registered network as programs run it, from frames: extremes, constants, ranges, bad samples.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/models/small_network.h"
#include "tests/runtime/run_graph.h"
#include "tests/stability/operator_cases.h"
#include "tests/support/random_frame.h"

namespace ld {
namespace {

/// A fifth of the samples are missing.
Frame frame_with_holes(int width, int height, int spp) {
  Frame frame = random_frame(width, height, spp, 5);
  for (size_t i = 0; i < frame.valid.size(); i += 5) frame.valid[i] = 0;
  sanitise(frame);
  return frame;
}

/// The same light in all samples, and one reflectance: what a demodulating network divides by.
void make_constant(Frame& frame, float radiance) {
  for (int s = 0; s < frame.spp; ++s)
    for (int c = 0; c < kSampleChannels; ++c) {
      const bool light = c >= kRadianceOffset && c < kRadianceOffset + 3;
      const bool colour = c >= find_feature("albedo").offset && c < find_feature("albedo").offset + 3;
      if (light || colour)
        std::fill_n(frame.plane(s, c), frame.plane_size(), light ? radiance : 0.5F);
      else if (c >= find_feature("specular").offset && c < find_feature("specular").offset + 3)
        std::fill_n(frame.plane(s, c), frame.plane_size(), 0.0F);
    }
}

bool finite_picture(const Image& image) {
  return std::all_of(image.pixels.begin(), image.pixels.end(), [](float v) { return std::isfinite(v); });
}

TEST(Graphs, PicturesStayFiniteAtEveryExtreme) {
  for (const NetworkConfig& config : every_network()) {
    const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
    for (const float number : extreme_numbers())
      for (const bool in_guides : {true, false}) {
        Frame frame = random_frame(7, 6, 3);
        for (size_t i = 0; i < frame.plane_size(); ++i)
          for (int c = in_guides ? 3 : 0; c < (in_guides ? kSampleChannels : 3); ++c)
            if ((i * 7 + size_t(c)) % 5 == 0) frame.plane(int(i) % 3, c)[i] = number;
        sanitise(frame);
        EXPECT_TRUE(finite_picture(in_runtime(config, weights, frame)))
            << title(config) << fmt::format(": {:g} in ", number) << (in_guides ? "guides" : "radiance");
      }
  }
}

TEST(Graphs, AConstantStaysForLogitsOfAnySizeAndOneToEightLayers) {
  for (NetworkConfig config : averaging_configs())
    for (const int64_t layers :
         has_layers(config) ? std::vector<int64_t>{1, 2, 5, 8} : std::vector<int64_t>{2})
      for (const double scale : {1.0, 100.0, 1e4})
        for (const float light : {0.7F, 1e-30F, 65504.0F, 3e38F}) {
          config.layers = layers;
          config.kernel_size = 5;
          const auto network = small_network(config, torch::kFloat32);
          scale_logits(*network, scale);
          Frame frame = random_frame(10, 9, 3);
          make_constant(frame, light);
          const Image picture = in_runtime(config, weights_of(*network), frame);
          for (const float value : picture.pixels)
            ASSERT_NEAR(value / light, 1, 1e-5)
                << title(config) << ", logits times " << scale << ", " << light;
        }
}

TEST(Graphs, TheResultLiesWithinTheSamples) {
  for (const NetworkConfig& config : averaging_configs())
    for (const double scale : {1.0, 30.0}) {
      const auto network = small_network(config, torch::kFloat32);
      scale_logits(*network, scale);
      Frame frame = frame_with_holes(26, 24, 3);
      make_constant(frame, 1);
      float least = 1, largest = 0;
      for (int s = 0; s < frame.spp; ++s)
        for (size_t p = 0; p < frame.plane_size(); ++p)
          for (int c = 0; c < 3; ++c) {
            float& value = frame.plane(s, c)[p];
            value = frame.valid_plane(s)[p] == 0 ? 0 : 0.25F + float((p * 31 + size_t(s)) % 64) / 80;
            if (value == 0) continue;
            least = std::min(least, value);
            largest = std::max(largest, value);
          }
      for (const float value : in_runtime(config, weights_of(*network), frame).pixels) {
        ASSERT_GE(value, least - 1e-6F) << title(config);
        ASSERT_LE(value, largest + 1e-6F) << title(config);
      }
    }
}

TEST(Graphs, ABadSampleIsLikeOneThatWasNeverDrawn) {
  for (const NetworkConfig& config : every_network()) {
    const NamedWeights weights = weights_of(*small_network(config, torch::kFloat32));
    for (const float bad : {std::nanf(""), HUGE_VALF, -HUGE_VALF}) {
      Frame frame = frame_with_holes(9, 8, 3), without = frame;
      for (const size_t p : {size_t(1), size_t(23), size_t(70)}) {
        frame.plane(1, 2)[p] = bad;
        without.valid_plane(1)[p] = 0;
        for (int c = 0; c < kSampleChannels; ++c) without.plane(1, c)[p] = 0;
      }
      sanitise(frame);
      EXPECT_EQ(in_runtime(config, weights, frame).pixels, in_runtime(config, weights, without).pixels)
          << title(config);
    }
  }
}

}  // namespace
}  // namespace ld
