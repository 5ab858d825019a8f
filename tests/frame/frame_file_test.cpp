#include "frame/frame_file.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

#include "core/file_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

Frame read_all(const std::filesystem::path& path, Faults& faults) {
  return read_frame(path, mh20_feature_names(), faults);
}

class FrameSizes : public testing::TestWithParam<std::array<int, 3>> {};

TEST_P(FrameSizes, RoundTripIsExactAtHalfPrecision) {
  const TemporaryFolder folder;
  const auto [width, height, spp] = GetParam();
  Frame frame = random_frame(width, height, spp);
  frame.info.generator = "test 1.0";
  frame.info.scene = "odd sizes";
  frame.info.camera = "fov 45";
  frame.info.seed = 0xffffffffffffffffULL;
  frame.info.frame = 123456789012;
  EXPECT_EQ(write_frame(folder / "frame.exr", frame), 0);

  Faults faults;
  const Frame read = read_all(folder / "frame.exr", faults);
  EXPECT_FALSE(faults.any());
  EXPECT_EQ(read.width, width);
  EXPECT_EQ(read.height, height);
  EXPECT_EQ(read.spp, spp);
  EXPECT_EQ(read.samples, frame.samples);
  EXPECT_EQ(read.valid, frame.valid);
  EXPECT_EQ(read.info.generator, "test 1.0");
  EXPECT_EQ(read.info.scene, "odd sizes");
  EXPECT_EQ(read.info.camera, "fov 45");
  EXPECT_EQ(read.info.seed, 0xffffffffffffffffULL);
  EXPECT_EQ(read.info.frame, 123456789012);
  EXPECT_EQ(read.info.depth_scale, frame.info.depth_scale);

  const FrameHeader header = read_frame_header(folder / "frame.exr");
  EXPECT_EQ(header.width, width);
  EXPECT_EQ(header.height, height);
  EXPECT_EQ(header.spp, spp);
  EXPECT_EQ(header.features, mh20_feature_names());
  EXPECT_EQ(header.info.camera, "fov 45");

  // The first part is the picture: the mean of the samples, rounded to half.
  const Image mean = mean_radiance(frame);
  const Image picture = read_image(folder / "frame.exr");
  ASSERT_EQ(picture.pixels.size(), mean.pixels.size());
  for (size_t i = 0; i < mean.pixels.size(); ++i)
    EXPECT_EQ(picture.pixels[i], static_cast<float>(half(mean.pixels[i]))) << "at " << i;
}

INSTANTIATE_TEST_SUITE_P(Sizes, FrameSizes,
                         testing::Values(std::array{1, 1, 1}, std::array{1, 7, 2}, std::array{65, 3, 3},
                                         std::array{64, 64, 1}, std::array{5, 130, 2}));

TEST(FrameFile, NumbersThousandsOfSamples) {
  const TemporaryFolder folder;
  const Frame frame = random_frame(1, 1, 1001);
  write_frame(folder / "frame.exr", frame);
  Faults faults;
  EXPECT_EQ(read_all(folder / "frame.exr", faults).samples, frame.samples);
}

TEST(FrameFile, TheSameFrameGivesTheSameBytes) {
  const TemporaryFolder folder;
  const Frame frame = random_frame(33, 17, 2);
  write_frame(folder / "a.exr", frame);
  write_frame(folder / "b.exr", frame);
  EXPECT_EQ(read_file(folder / "a.exr"), read_file(folder / "b.exr"));
  // Read and written again, too.
  Faults faults;
  write_frame(folder / "c.exr", read_all(folder / "a.exr", faults));
  EXPECT_EQ(read_file(folder / "a.exr"), read_file(folder / "c.exr"));
}

TEST(FrameFile, HoldsTheFeaturesThatTheFrameHolds) {
  const TemporaryFolder folder;
  Frame frame = random_frame(5, 3, 2);
  EXPECT_FALSE(frame.holds("flow"));
  frame.features = {"flow", "normal", "radiance"};  // in any order
  for (int s = 0; s < 2; ++s)
    for (int c = 0; c < kSampleChannels; ++c) std::fill_n(frame.plane(s, c), 15, static_cast<float>(c));
  frame.info.depth_scale = 0;
  write_frame(folder / "frame.exr", frame);
  EXPECT_EQ(read_frame_header(folder / "frame.exr").features,
            (std::vector<std::string>{"radiance", "normal", "flow"}));
  Faults faults;
  const Frame read = read_frame(folder / "frame.exr", {"flow"}, faults);
  EXPECT_EQ(read.features, (std::vector<std::string>{"radiance", "normal", "flow"}));
  EXPECT_EQ(read.info.depth_scale, 1.0F);  // there is no depth
  for (int s = 0; s < 2; ++s)
    for (int c = 0; c < kSampleChannels; ++c) {
      const bool held = c < 6 || c >= kFlowOffset;
      EXPECT_EQ(read.plane(s, c)[7], held ? static_cast<float>(c) : 0.0F) << "channel " << c;
    }
  EXPECT_ERROR(read_frame(folder / "frame.exr", {"depth"}, faults), "the feature 'depth' is needed");

  write_frame(folder / "again.exr", read);
  EXPECT_EQ(read_file(folder / "frame.exr"), read_file(folder / "again.exr"));
  frame.features = {"normal"};
  EXPECT_ERROR(write_frame(folder / "frame.exr", frame), "holds no radiance");
  frame.features = {"radiance", "flows"};
  EXPECT_ERROR(write_frame(folder / "frame.exr", frame), "did you mean 'flow'");
}

TEST(FrameFile, AlphaAndWindowsSurvive) {
  const TemporaryFolder folder;
  Frame frame = random_frame(5, 3, 2);
  frame.alpha.assign(30, 1.0F);
  frame.alpha[7] = 0.25F;
  frame.alpha[15 + 7] = 0.5F;
  frame.alpha[15 + 8] = 0.0F;
  frame.valid_plane(1)[8] = 0;
  frame.info.windows.x = -2;
  frame.info.windows.y = 7;
  frame.info.windows.display_right = 99;
  frame.info.windows.display_bottom = 49;
  write_frame(folder / "frame.exr", frame);

  const FrameHeader header = read_frame_header(folder / "frame.exr");
  EXPECT_TRUE(header.alpha);
  EXPECT_EQ(header.info.windows, frame.info.windows);
  Faults faults;
  const Frame read = read_all(folder / "frame.exr", faults);
  EXPECT_EQ(read.alpha, frame.alpha);
  EXPECT_EQ(read.info.windows, frame.info.windows);
  EXPECT_EQ(read.width, 5);
  const Image mean = mean_alpha(read);
  EXPECT_EQ(mean.pixels[7], 0.375F);
  EXPECT_EQ(mean.pixels[8], 1.0F);  // of the one sample that counts
  write_frame(folder / "again.exr", read);
  EXPECT_EQ(read_file(folder / "frame.exr"), read_file(folder / "again.exr"));

  Image image(5, 3, 4);
  image.at(3, 2, 1) = 0.5F;
  write_image(folder / "image.exr", image, frame.info.windows);
  EXPECT_EQ(read_frame_header(folder / "image.exr").info.windows, frame.info.windows);
  EXPECT_ERROR(write_image(folder / "image.png", image), "4 channels");

  frame.alpha.pop_back();
  EXPECT_ERROR(write_frame(folder / "frame.exr", frame), "alpha for 29 samples; expected 30");
  frame.alpha.clear();
  frame.info.windows = {};
  write_frame(folder / "frame.exr", frame);
  EXPECT_FALSE(read_frame_header(folder / "frame.exr").alpha);
  EXPECT_TRUE(read_all(folder / "frame.exr", faults).alpha.empty());
}

TEST(FrameFile, AlphaIsMendedLikeTheRest) {
  Frame frame = random_frame(3, 1, 1);
  frame.alpha = {1.5F, kNaN, -0.5F};
  const Faults faults = sanitise(frame);
  EXPECT_EQ(faults.not_finite, 1);
  EXPECT_EQ(frame.alpha, (std::vector<float>{1, 0, 0}));
  EXPECT_EQ(frame.valid[1], 0);
}

TEST(Schema, TheTwentyChannelsOfThePaperComeFirst) {
  EXPECT_EQ(channel_count(mh20_feature_names()), 20);
  EXPECT_EQ(channel_count(auto_feature_names()), kSampleChannels);
  EXPECT_EQ(channel_count(feature_names()), kAllChannels);
  int offset = 0;
  for (const Feature& feature : feature_schema()) {
    EXPECT_EQ(feature.offset, offset) << feature.name;
    offset += feature.channels;
  }
  EXPECT_EQ(describe_features({"flow"}), "flow 2 squash 16\n");
}

TEST(FrameFile, MaskedSamplesStayMasked) {
  const TemporaryFolder folder;
  Frame frame = random_frame(4, 3, 2);
  frame.valid_plane(0)[5] = 0;
  frame.valid_plane(1)[5] = 0;
  frame.valid_plane(1)[7] = 0;
  write_frame(folder / "frame.exr", frame);
  Faults faults;
  const Frame read = read_all(folder / "frame.exr", faults);
  EXPECT_EQ(faults.not_finite, 3);
  EXPECT_EQ(read.valid, frame.valid);
  for (int c = 0; c < kSampleChannels; ++c) {
    EXPECT_EQ(read.plane(1, c)[7], 0.0F) << "channel " << c;
    EXPECT_EQ(read.plane(0, c)[7], frame.plane(0, c)[7]) << "channel " << c;
  }
  // A pixel without a sample is black in the picture, not NaN.
  int64_t bad = -1;
  const Image picture = read_image(folder / "frame.exr", &bad);
  EXPECT_EQ(bad, 0);
  EXPECT_EQ(picture.at(1, 1, 1), 0.0F);
  EXPECT_EQ(picture.at(1, 3, 1), static_cast<float>(half(frame.plane(0, 1)[7])));
}

TEST(FrameFile, CountsAndMendsWhatRenderersGetWrong) {
  const TemporaryFolder folder;
  Frame frame = random_frame(4, 2, 1);
  frame.plane(0, 0)[0] = kNaN;
  frame.plane(0, 1)[1] = kInfinity;
  frame.plane(0, kNormalOffset)[2] = kNaN;
  frame.plane(0, 2)[3] = -0.5F;
  frame.plane(0, 0)[4] = 65505.0F;
  frame.plane(0, 1)[4] = 1e30F;
  frame.plane(0, 2)[4] = 65504.0F;
  frame.plane(0, kDepthOffset)[5] = 1e9F;  // clamped like an escaped ray's, which is no fault of the radiance
  EXPECT_EQ(write_frame(folder / "frame.exr", frame), 2);

  Faults faults;
  const Frame read = read_all(folder / "frame.exr", faults);
  EXPECT_EQ(faults.not_finite, 2);
  EXPECT_EQ(faults.guides, 1);
  EXPECT_EQ(faults.negative, 1);
  EXPECT_EQ(faults.clamped, 2);
  EXPECT_EQ(read.valid, (std::vector<uint8_t>{0, 0, 1, 1, 1, 1, 1, 1}));
  for (int c = 0; c < 3; ++c)
    EXPECT_EQ(read.plane(0, kNormalOffset + c)[2], 0.0F) << "a bad guide costs the guide";
  EXPECT_EQ(read.plane(0, 1)[2], static_cast<float>(half(frame.plane(0, 1)[2]))) << "not the light";
  EXPECT_EQ(read.plane(0, 2)[3], 0.0F);
  EXPECT_EQ(read.plane(0, 0)[4], 0.0F) << "0.0043 of a colour of 1e30";
  EXPECT_EQ(read.plane(0, 1)[4], 65504.0F);
  EXPECT_EQ(read.plane(0, kDepthOffset)[5], kEscapedDepth);

  // The picture shows the mended samples.
  int64_t bad = -1;
  const Image picture = read_image(folder / "frame.exr", &bad);
  EXPECT_EQ(bad, 0);
  EXPECT_EQ(picture.plane(1)[4], 65504.0F);
  EXPECT_EQ(picture.plane(2)[3], 0.0F);

  // A second generation remembers what the first one clamped.
  EXPECT_EQ(write_frame(folder / "again.exr", read), 0);
  EXPECT_EQ(read_frame_header(folder / "again.exr").info.clamped, 2);
}

TEST(FrameFile, FindsTheDepthScaleWhenTheWriterDidNot) {
  const TemporaryFolder folder;
  Frame frame = random_frame(3, 1, 1);
  const float depths[] = {4.0F, 2.0F, kEscapedDepth};
  std::copy(depths, depths + 3, frame.plane(0, kDepthOffset));
  frame.info.depth_scale = 0;
  write_frame(folder / "frame.exr", frame);
  EXPECT_EQ(read_frame_header(folder / "frame.exr").info.depth_scale, 4.0F);
}

TEST(FrameFile, AFailedWriteLeavesNothing) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "file", "in the way");
  EXPECT_ERROR(write_frame(folder / "file/frame.exr", random_frame(2, 2, 1)), "cannot make the folder");
  EXPECT_ERROR(write_frame(folder / "empty.exr", Frame()), "a frame of 0 x 0");
  Frame short_mask = random_frame(2, 2, 1);
  short_mask.valid.pop_back();
  EXPECT_ERROR(write_frame(folder / "empty.exr", short_mask), "3 mask entries");
  EXPECT_FALSE(std::filesystem::exists(folder / "empty.exr"));
}

TEST(FrameFile, OpensInOtherPrograms) {
  const TemporaryFolder folder;
  write_frame(folder / "frame.exr", random_frame(65, 3, 2));
  if (std::system("oiiotool --help > /dev/null 2>&1") != 0) GTEST_SKIP() << "oiiotool is not installed";
  const std::string command = "oiiotool --info -v -a '" + (folder / "frame.exr").string() + "' 2>&1";
  FILE* pipe = popen(command.c_str(), "r");
  ASSERT_NE(pipe, nullptr);
  std::string output;
  std::array<char, 4096> buffer;
  for (size_t n; (n = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;) output.append(buffer.data(), n);
  EXPECT_EQ(pclose(pipe), 0);
  const size_t mean = output.find("oiio:subimagename: \"mean\""),
               first = output.find("oiio:subimagename: \"s000\"");
  EXPECT_NE(mean, std::string::npos) << output;
  EXPECT_NE(first, std::string::npos) << output;
  EXPECT_LT(mean, first);
  EXPECT_NE(output.find("65 x    3, 3 channel, half"), std::string::npos) << output;
  EXPECT_NE(output.find("albedo.R"), std::string::npos) << output;
}

}  // namespace
}  // namespace ld
