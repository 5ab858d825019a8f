#include "filters/frame_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/error.h"

namespace ld {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
const int kAlbedo = find_feature("albedo").offset;

/// A textured wall that faces the camera, lit by constant light with noise of a deviation of `noise`; all
/// features that the filters read but the matrices.
Frame wall_frame(int width, int height, int spp, float noise, uint64_t seed) {
  Frame frame(width, height, spp, kAllChannels);
  frame.features = filter_features();
  frame.features.emplace_back("radiance");
  frame.info.depth_scale = 10;
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal;
  for (int s = 0; s < spp; ++s)
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) {
        const size_t p = size_t(y) * size_t(width) + size_t(x);
        const float albedo = (x / 3 + y / 3) % 2 == 0 ? 0.8F : 0.1F;
        frame.plane(s, kNormalOffset + 2)[p] = 1;
        frame.plane(s, kDepthOffset)[p] = 10;
        frame.plane(s, kIdOffset)[p] = 1;
        const float direct = std::max(2 + noise * normal(random), 0.0F),
                    indirect = std::max(0.5F + noise * normal(random), 0.0F);
        for (int c = 0; c < 3; ++c) {
          frame.plane(s, kAlbedo + c)[p] = albedo;
          frame.plane(s, kDirectOffset + c)[p] = albedo * direct;
          frame.plane(s, kIndirectOffset + c)[p] = albedo * indirect;
          frame.plane(s, kRadianceOffset + c)[p] = albedo * (direct + indirect);
        }
      }
  return frame;
}

FilterArgument filter(const std::string& kind, std::vector<std::string> assignments = {}) {
  return {kind, kind, std::move(assignments)};
}

Image denoise_once(const FilterArgument& argument, const Frame& frame, int threads = 1) {
  SequenceState state;
  state.advance(std::nullopt, frame.width, frame.height);
  return FrameFilter(argument).denoise(frame, state, threads);
}

double largest_error(const Image& a, const Image& b) {
  double largest = 0;
  for (size_t i = 0; i < a.pixels.size(); ++i)
    largest = std::max(largest, double(std::abs(a.pixels[i] - b.pixels[i])));
  return largest;
}

TEST(FrameFilter, TextureIsKeptBecauseTheLightIsFilteredWithoutIt) {
  const Frame frame = wall_frame(48, 36, 2, 0, 1);
  const Image exact = mean_radiance(frame);
  for (const std::string kind : {"eaw", "svgf"}) {
    EXPECT_LE(largest_error(denoise_once(filter(kind), frame), exact), 1e-5) << kind;
    EXPECT_LE(largest_error(denoise_once(filter(kind, {"split=false"}), frame), exact), 1e-5) << kind;
    EXPECT_GE(largest_error(denoise_once(filter(kind, {"demodulate=false"}), frame), exact), 0.1) << kind;
  }
}

TEST(FrameFilter, LightOfASampleIsDividedByItsOwnColour) {
  // Two samples a pixel, of a bright and of a dark surface under constant light, and one of the sky.
  Frame frame(6, 4, 3, kAllChannels);
  frame.features = {"radiance", "albedo", "depth"};
  for (size_t p = 0; p < 24; ++p)
    for (int s = 0; s < 3; ++s) {
      frame.plane(s, kDepthOffset)[p] = s == 2 ? kEscapedDepth : 10;
      for (int c = 0; c < 3; ++c) {
        frame.plane(s, kAlbedo + c)[p] = s == 0 ? 0.8F : s == 1 ? 0.1F : 0.0F;
        frame.plane(s, kRadianceOffset + c)[p] = s == 0 ? 1.6F : s == 1 ? 0.2F : 5.0F;
      }
    }
  Surfaces surfaces;
  Illumination light;
  IlluminationSettings settings;
  settings.per_sample = true;
  read_guides(frame, settings, surfaces, light, 1);
  // 2 on each surface, and nothing from the sky, which is emission.
  EXPECT_NEAR(light.signals.at(3, 2, 0), 4.0F / 3, 1e-6);
  EXPECT_NEAR(light.emission.at(3, 2, 0), 5.0F / 3, 1e-6);
  EXPECT_NEAR(light.albedo.at(3, 2, 0), 0.3, 1e-6);
  const Frame wall = wall_frame(48, 36, 4, 0, 1);
  for (const std::string kind : {"eaw", "svgf"})
    EXPECT_LE(largest_error(denoise_once(filter(kind, {"per_sample=true"}), wall), mean_radiance(wall)), 1e-5)
        << kind;
}

TEST(FrameFilter, DividedLightIsThatOfAWhiteSurface) {
  // Of a diffuse surface the light without its colour can be had by division or by tracing it in white.
  const Frame frame = wall_frame(30, 20, 1, 0.7F, 3);
  Surfaces surfaces;
  Illumination light;
  read_guides(frame, {}, surfaces, light, 1);
  for (int y = 0; y < 20; ++y)
    for (int x = 0; x < 30; ++x) {
      const float white = frame.plane(0, kDirectOffset)[y * 30 + x] / frame.plane(0, kAlbedo)[y * 30 + x];
      ASSERT_FLOAT_EQ(light.signals.at(x, y, 0), white);
    }
}

TEST(FrameFilter, TheSurfaceOfAPixelIsThatOfTheLowerMedianDepth) {
  Frame frame = wall_frame(1, 1, 4, 0, 1);
  const float depths[4] = {7, 3, 9, 5};
  for (int s = 0; s < 4; ++s) {
    frame.plane(s, kDepthOffset)[0] = depths[s];
    frame.plane(s, kIdOffset)[0] = float(10 + s);
    frame.plane(s, kFlowOffset)[0] = float(s);
    frame.plane(s, kFlowDepthOffset)[0] = 0.1F * float(s);
  }
  Surfaces surfaces;
  Illumination light;
  read_guides(frame, {}, surfaces, light, 1);
  EXPECT_EQ(surfaces.of.at(0, 0, kDepth), 5);
  EXPECT_EQ(surfaces.of.at(0, 0, kId), 13);
  EXPECT_EQ(surfaces.flow.at(0, 0, 0), 3);
  EXPECT_FLOAT_EQ(surfaces.flow.at(0, 0, 2), 0.3F);
  frame.valid_plane(3)[0] = 0;  // 3, 7, 9 are left
  for (int c = 0; c < kAllChannels; ++c) frame.plane(3, c)[0] = 0;
  read_guides(frame, {}, surfaces, light, 1);
  EXPECT_EQ(surfaces.of.at(0, 0, kDepth), 7);
  EXPECT_NEAR(light.signals.at(0, 0, 0), 2, 1e-6);  // the mean of those that were drawn
}

TEST(FrameFilter, CompressionDarkensNoiseAndIsUndoneWithoutIt) {
  const Frame clean = wall_frame(40, 40, 1, 0, 1);
  EXPECT_LE(largest_error(denoise_once(filter("eaw"), clean), mean_radiance(clean)), 1e-5);
  const Frame noisy = wall_frame(40, 40, 1, 0.8F, 2);
  const auto mean = [](const Image& image) {
    double sum = 0;
    for (const float v : image.pixels) sum += v;
    return sum / double(image.pixels.size());
  };
  const double input = mean(mean_radiance(noisy));
  EXPECT_LT(mean(denoise_once(filter("eaw", {"compress=reinhard"}), noisy)), 0.97 * input);
  EXPECT_NEAR(mean(denoise_once(filter("svgf", {"compress=none"}), noisy)), input, 0.03 * input);
}

TEST(FrameFilter, ALampThatGoesOutIsGoneWithinThreeFramesWithAntilag) {
  // One noisy sample a pixel; what is left of the step, over the wall.
  const auto left_after = [](const std::string& antilag, int frames) {
    FrameFilter svgf(filter("svgf", {"antilag=" + antilag}));
    SequenceState state;
    double mean = 0;
    for (int f = 0; f < 10 + frames; ++f) {
      Frame frame = wall_frame(60, 40, 1, 0.8F, uint64_t(f));
      if (f >= 10)
        for (const int first : {kRadianceOffset, kDirectOffset, kIndirectOffset})
          for (int c = first; c < first + 3; ++c)
            for (size_t p = 0; p < frame.plane_size(); ++p) frame.plane(0, c)[p] *= 0.05F;
      state.advance(SequencePlace{0, f}, frame.width, frame.height);
      const Image picture = svgf.denoise(frame, state, 1);
      double sum = 0;
      for (const float v : picture.pixels) sum += v / double(picture.pixels.size());
      if (f == 9) mean = sum;
      if (f == 9 + frames) return (sum - 0.05 * mean) / (0.95 * mean);
    }
    return 1.0;
  };
  EXPECT_LT(std::abs(left_after("clip", 3)), 0.05);
  EXPECT_GT(left_after("none", 3), 0.4) << "0.8^3";
}

TEST(FrameFilter, BrightPixelsAreBoundedByThoseAroundThem) {
  Frame frame = wall_frame(20, 20, 1, 0, 1);
  const size_t p = 10 * 20 + 10;
  for (int c = 0; c < 3; ++c) {
    frame.plane(0, kDirectOffset + c)[p] = 1000;
    frame.plane(0, kRadianceOffset + c)[p] = 1000;
  }
  Surfaces surfaces;
  Illumination light;
  RowPlanes spare;
  read_guides(frame, {}, surfaces, light, 1);
  bound_fireflies(light.signals, spare, 2, 1);
  EXPECT_NEAR(light.signals.at(10, 10, 1), 4, 1e-3);  // twice the mean of those around it
  EXPECT_NEAR(light.signals.at(9, 10, 1), 2, 1e-5);
}

TEST(FrameFilter, LightsAndSkyPassThrough) {
  Frame frame = wall_frame(30, 20, 1, 0.5F, 4);
  for (int x = 0; x < 10; ++x)
    for (int y = 0; y < 20; ++y) {
      const size_t p = size_t(y) * 30 + size_t(x);
      for (int c = 0; c < 3; ++c) {
        frame.plane(0, c)[p] = frame.plane(0, kEmissionOffset + c)[p] = float(x + y);
        frame.plane(0, kDirectOffset + c)[p] = frame.plane(0, kIndirectOffset + c)[p] = 0;
        frame.plane(0, kAlbedo + c)[p] = 0;
      }
      if (x < 5) frame.plane(0, kDepthOffset)[p] = kEscapedDepth;  // the sky; the others a light
      frame.plane(0, kIdOffset)[p] = x < 5 ? 0.0F : 2.0F;
    }
  for (const std::string kind : {"eaw", "svgf"}) {
    const Image out = denoise_once(filter(kind), frame);
    for (int y = 0; y < 20; ++y)
      for (int x = 0; x < 10; ++x) ASSERT_NEAR(out.at(1, x, y), x + y, 1e-5) << kind;
  }
}

TEST(FrameFilter, NotFiniteSamplesCostThemselvesAlone) {
  Frame frame = wall_frame(40, 30, 1, 0.2F, 5), whole = frame;
  const size_t p = 15 * 40 + 20;
  frame.plane(0, 0)[p] = kNan;
  frame.plane(0, 1)[p + 3] = std::numeric_limits<float>::infinity();
  frame.plane(0, kDepthOffset)[p + 6] = kNan;
  const Faults faults = sanitise(frame);
  EXPECT_EQ(faults.not_finite, 2);
  EXPECT_EQ(faults.guides, 1);
  for (const std::string kind : {"eaw", "svgf"}) {
    const Image out = denoise_once(filter(kind), frame), clean = denoise_once(filter(kind), whole);
    for (const float v : out.pixels) ASSERT_TRUE(std::isfinite(v)) << kind;
    EXPECT_NEAR(out.at(0, 0, 0), clean.at(0, 0, 0), 0.01F);
    EXPECT_EQ(out.at(0, 20, 15), 0);  // nothing is known of it
  }
}

TEST(FrameFilter, AnySizeAnyThreadsAnyLight) {
  for (const std::string kind : {"eaw", "svgf"}) {
    for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {1, 9}, {37, 23}}) {
      const Frame frame = wall_frame(width, height, 1, 0.5F, 6);
      const Image one = denoise_once(filter(kind), frame, 1), three = denoise_once(filter(kind), frame, 3);
      EXPECT_EQ(one.width, width);
      EXPECT_EQ(one.pixels, three.pixels);
    }
    for (const float bright : {0.0F, 1e-45F, 1e-38F, 65504.0F, 3e38F}) {
      Frame frame = wall_frame(20, 10, 1, 0, 7);
      for (size_t p = 0; p < frame.plane_size(); p += 3)
        for (int c = 0; c < 3; ++c) frame.plane(0, c)[p] = frame.plane(0, kDirectOffset + c)[p] = bright;
      for (const std::string split : {"split=true", "split=false"})
        for (const float v : denoise_once(filter(kind, {split}), frame).pixels)
          ASSERT_TRUE(std::isfinite(v)) << kind << bright;
    }
  }
}

TEST(FrameFilter, SequencesGoOnAndStartAnewAtHoles) {
  FrameFilter svgf(filter("svgf"));
  SequenceState state;
  std::vector<Image> pictures;
  const auto frame_at = [](int64_t position) { return wall_frame(40, 30, 1, 0.8F, uint64_t(position)); };
  for (const int64_t position : {0, 1, 2, 3, 5, 6}) {  // 4 is missing
    const Frame frame = frame_at(position);
    state.advance(SequencePlace{0, position}, 40, 30);
    pictures.push_back(svgf.denoise(frame, state, 2));
  }
  EXPECT_EQ(pictures[0].pixels, denoise_once(filter("svgf"), frame_at(0)).pixels);
  EXPECT_NE(pictures[3].pixels, denoise_once(filter("svgf"), frame_at(3)).pixels);
  EXPECT_EQ(pictures[4].pixels, denoise_once(filter("svgf"), frame_at(5)).pixels);
  EXPECT_NE(pictures[5].pixels, denoise_once(filter("svgf"), frame_at(6)).pixels);
}

TEST(FrameFilter, ACutStartsAnew) {
  FrameFilter svgf(filter("svgf"));
  SequenceState state;
  state.advance(SequencePlace{0, 0}, 40, 30);
  svgf.denoise(wall_frame(40, 30, 1, 0.8F, 1), state, 1);
  state.advance(SequencePlace{0, 1}, 40, 30);
  Frame frame = wall_frame(40, 30, 1, 0.8F, 2);
  frame.info.cut = true;
  EXPECT_EQ(svgf.denoise(frame, state, 1).pixels, denoise_once(filter("svgf"), frame).pixels);
}

/// A camera at the origin that looks along a direction in the x-z plane.
CameraPlace turned_camera(double angle) {
  CameraPlace camera{};
  camera.right = {std::cos(angle), 0, -std::sin(angle)};
  camera.up = {0, 1, 0};
  camera.back = {std::sin(angle), 0, std::cos(angle)};
  return camera;
}

TEST(FrameFilter, PositionsAndNormalsComeFromTheMatrices) {
  Frame frame = wall_frame(8, 4, 1, 0, 1);
  const CameraPlace camera = turned_camera(0.5);
  frame.info.world_to_camera = world_to_camera(camera);
  frame.info.world_to_ndc = world_to_ndc(camera, 0.8, 0.4);
  Surfaces surfaces;
  Illumination light;
  read_guides(frame, {}, surfaces, light, 1);
  ASSERT_TRUE(surfaces.has_position);
  // Pixel (6, 1) lies at 6.5/8 and 1.5/4 of the picture; the wall is 10 away.
  EXPECT_NEAR(surfaces.of.at(6, 1, kPositionX) - surfaces.of.at(1, 1, kPositionX), 10 * 0.8 * 2 * 5 / 8.0,
              1e-4);
  EXPECT_NEAR(std::abs(surfaces.of.at(6, 1, kPositionY)), 10 * 0.4 * (1 - 2 * 1.5 / 4), 1e-4);
  EXPECT_NEAR(surfaces.of.at(6, 1, kNormalX), std::sin(0.5), 1e-5);  // it faces the camera
  EXPECT_NEAR(surfaces.of.at(6, 1, kNormalZ), std::cos(0.5), 1e-5);
}

TEST(FrameFilter, ACameraThatTurnsKeepsTheHistoryOfAWall) {
  // The wall's normal is the world's +z; the camera turns by 30 degrees a frame, which view space cannot
  // know.
  for (const bool told : {true, false}) {
    FrameFilter svgf(filter("svgf"));
    SequenceState state;
    for (int f = 0; f < 5; ++f) {
      Frame frame = wall_frame(12, 10, 1, 0.5F, uint64_t(f));
      const CameraPlace camera = turned_camera(0.5 * f);
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        frame.plane(0, kNormalOffset)[p] = float(camera.right[2]);
        frame.plane(0, kNormalOffset + 2)[p] = float(camera.back[2]);
      }
      if (told) frame.info.world_to_camera = world_to_camera(camera);
      state.advance(SequencePlace{0, f}, 12, 10);
      svgf.denoise(frame, state, 1);
      EXPECT_EQ(std::any_cast<TemporalState&>(state.memory).light.length_row(5)[6],
                told ? float(f + 1) : 1.0F);
    }
  }
}

TEST(FrameFilter, NamesWhatAFrameLacks) {
  Frame frame(4, 4, 1);
  frame.features = {"radiance"};
  EXPECT_EQ(missing_guides(frame, true).size(), 8U);
  EXPECT_EQ(missing_guides(frame, false).size(), 7U);
  Frame full = wall_frame(4, 4, 1, 0, 1);
  EXPECT_EQ(missing_guides(full, true).size(), 1U);  // the matrices
  full.info.world_to_camera = world_to_camera(turned_camera(0));
  full.info.world_to_ndc = world_to_ndc(turned_camera(0), 1, 1);
  EXPECT_TRUE(missing_guides(full, true).empty());
}

TEST(FrameFilter, FramesOfRadianceAloneAreFilteredToo) {
  Frame frame(30, 20, 2);
  frame.features = {"radiance"};
  for (size_t p = 0; p < frame.plane_size(); ++p) frame.plane(int(p % 2), 1)[p] = 1;
  for (const std::string kind : {"eaw", "svgf"})
    for (const float v : denoise_once(filter(kind), frame).pixels) ASSERT_TRUE(std::isfinite(v));
}

TEST(FrameFilter, ArgumentsNameKindsAndSettings) {
  std::vector<std::string> set = {"soft.levels=3", "depth.scale=2", "svgf.alpha=0.1", "soft.kernel=gauss"};
  const auto filters = parse_filter_arguments({"soft=eaw", "svgf"}, set);
  ASSERT_EQ(filters.size(), 2U);
  EXPECT_EQ(filters[0].name, "soft");
  EXPECT_EQ(filters[0].kind, "eaw");
  EXPECT_EQ(filters[0].assignments, (std::vector<std::string>{"levels=3", "kernel=gauss"}));
  EXPECT_EQ(FrameFilter(filters[0]).description(), "eaw (levels=3, kernel=gauss)");
  EXPECT_EQ(filters[1].assignments, (std::vector<std::string>{"alpha=0.1"}));
  EXPECT_EQ(set, (std::vector<std::string>{"depth.scale=2"}));
  EXPECT_THROW(parse_filter_arguments({"bilateral"}, set), UsageError);
  EXPECT_THROW(parse_filter_arguments({"eaw", "eaw"}, set), UsageError);
  EXPECT_THROW(FrameFilter(filter("eaw", {"sigma=1"})), UsageError);
  EXPECT_THROW(FrameFilter(filter("svgf", {"alpha=2"})), UsageError);
  EXPECT_THROW(FrameFilter(filter("svgf", {"levels=2", "feedback=2"})), UsageError);
}

}  // namespace
}  // namespace ld
