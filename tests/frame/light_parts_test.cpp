// Parts of the light beside the radiance of samples: in memory and in files.
#include <gtest/gtest.h>

#include <limits>

#include "frame/frame_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

Frame frame_with_parts(int width, int height, int spp) {
  Frame frame = random_frame(width, height, spp);
  RandomStream random(2, RandomPurpose::test);
  for (const char* name : {"diffuse", "light_key", "light_rim"})
    for (float& value : frame.add_part(name).samples) value = float(half(random.uniform(-1.0F, 1.0F)));
  return frame;
}

Frame read_also(const std::filesystem::path& path, const std::vector<std::string>& also, Faults& faults,
                int samples = 0) {
  return read_frame(path, {}, faults, samples, 2, also);
}

TEST(LightPartFiles, ComeBackByTheirNames) {
  const TemporaryFolder folder;
  for (const auto& [width, height, spp] : {std::tuple(1, 1, 1), std::tuple(67, 5, 3)}) {
    const Frame frame = frame_with_parts(width, height, spp);
    write_frame(folder / "frame.exr", frame);
    const std::vector<std::string> names = {"diffuse", "light_key", "light_rim"};
    EXPECT_EQ(read_frame_header(folder / "frame.exr").layers, names);
    Faults faults;
    EXPECT_TRUE(read_also(folder / "frame.exr", {}, faults).parts.empty());
    const Frame all = read_also(folder / "frame.exr", {"*"}, faults);
    ASSERT_EQ(all.parts.size(), 3u);
    for (size_t i = 0; i < 3; ++i) {
      EXPECT_EQ(all.parts[i].name, names[i]);
      EXPECT_EQ(all.parts[i].samples, frame.parts[i].samples);
    }
    const Frame lights = read_also(folder / "frame.exr", {"light_r*", "light_[kr]*"}, faults);
    ASSERT_EQ(lights.parts.size(), 2u);
    EXPECT_EQ(lights.parts[1].samples, frame.parts[2].samples);
    EXPECT_FALSE(faults.any());
    EXPECT_ERROR(read_also(folder / "frame.exr", {"d*", "emission"}, faults),
                 "no part of the light is called 'emission'; there are diffuse, light_key, light_rim");
    Frame fewer = all;
    keep_first_samples(fewer, 1, "frame.exr");
    EXPECT_EQ(fewer.parts[0].samples, read_also(folder / "frame.exr", {"*"}, faults, 1).parts[0].samples);
  }
}

TEST(LightPartFiles, FeaturesAndLayersThatSomeSamplesLackAreNoParts) {
  const TemporaryFolder folder;
  write_frame(folder / "frame.exr", random_frame(4, 3, 2));
  EXPECT_TRUE(read_frame_header(folder / "frame.exr").layers.empty());
  Faults faults;
  EXPECT_ERROR(read_also(folder / "frame.exr", {"albedo"}, faults), "there is none");
}

TEST(LightPartFiles, FeaturesThatAreLightArePartsToo) {
  const TemporaryFolder folder;
  const Frame plain = random_frame(5, 3, 2);
  Frame frame(5, 3, 2, kAllChannels);
  for (int s = 0; s < frame.spp; ++s)
    std::copy_n(plain.plane(s, 0), size_t(kSampleChannels) * plain.plane_size(), frame.plane(s, 0));
  for (const char* name : {"direct", "indirect", "emission"}) {
    frame.features.emplace_back(name);
    for (int s = 0; s < frame.spp; ++s)
      std::fill_n(frame.plane(s, find_feature(name).offset), 3 * frame.plane_size(), 0.25F + float(s));
  }
  write_frame(folder / "frame.exr", frame);
  Faults faults;
  const Frame read = read_also(folder / "frame.exr", {"*direct"}, faults);
  ASSERT_EQ(read.parts.size(), 2u);
  EXPECT_EQ(read.parts[0].name, "direct");
  for (int s = 0; s < frame.spp; ++s)
    for (int c = 0; c < 3; ++c)
      for (size_t p = 0; p < frame.plane_size(); ++p) {
        ASSERT_EQ(read.part_plane(1, s, c)[p], 0.25F + float(s));
        ASSERT_EQ(read.plane(s, kIndirectOffset + c)[p], 0.25F + float(s));
      }
}

TEST(LightPartFiles, NamesOfFeaturesAndTwins) {
  const TemporaryFolder folder;
  for (const char* name : {"albedo", "diffuse", ""}) {
    Frame frame = frame_with_parts(3, 2, 1);
    frame.add_part(name);
    EXPECT_ERROR(write_frame(folder / "frame.exr", frame), "cannot be the name of a light part");
  }
}

TEST(LightPartFiles, WhatIsNotFiniteIsZeroAndCountedButKeepsItsSample) {
  const TemporaryFolder folder;
  Frame frame = frame_with_parts(5, 4, 2);
  frame.part_plane(0, 1, 2)[7] = std::numeric_limits<float>::quiet_NaN();
  frame.part_plane(1, 0, 0)[3] = -std::numeric_limits<float>::infinity();
  frame.plane(1, 0)[9] = std::numeric_limits<float>::quiet_NaN();  // the sample does not count
  frame.part_plane(2, 1, 1)[9] = std::numeric_limits<float>::infinity();
  write_frame(folder / "frame.exr", frame);
  Faults faults;
  const Frame read = read_also(folder / "frame.exr", {"*"}, faults);
  EXPECT_EQ(faults.parts, 2);
  EXPECT_EQ(faults.not_finite, 1);
  for (int c = 0; c < 3; ++c) {
    EXPECT_EQ(read.part_plane(0, 1, c)[7], 0);
    EXPECT_EQ(read.part_plane(1, 0, c)[3], 0);
    EXPECT_EQ(read.part_plane(0, 1, c)[9], 0);
    EXPECT_EQ(read.part_plane(0, 1, c)[8], frame.part_plane(0, 1, c)[8]);
  }
  EXPECT_EQ(read.valid_plane(1)[7], 1);
  EXPECT_EQ(read.valid_plane(1)[9], 0);
}

TEST(LightPartFiles, GetDarkerWithRadianceThatHalfFloatsDoNotReach) {
  const TemporaryFolder folder;
  Frame frame = frame_with_parts(2, 1, 1);
  for (int c = 0; c < 3; ++c) {
    frame.plane(0, c)[0] = 4 * kHalfMax;
    frame.part_plane(0, 0, c)[0] = 3 * kHalfMax;
    frame.part_plane(1, 0, c)[0] = kHalfMax;
  }
  EXPECT_EQ(write_frame(folder / "frame.exr", frame), 3);
  Faults faults;
  const Frame read = read_also(folder / "frame.exr", {"diffuse", "light_key"}, faults);
  EXPECT_NEAR(read.part_plane(0, 0, 0)[0] / read.plane(0, 0)[0], 0.75, 1e-3);
  EXPECT_NEAR(read.part_plane(1, 0, 2)[0] / read.plane(0, 0)[0], 0.25, 1e-3);
  EXPECT_EQ(read.part_plane(0, 0, 0)[1], frame.part_plane(0, 0, 0)[1]);
}

}  // namespace
}  // namespace ld
