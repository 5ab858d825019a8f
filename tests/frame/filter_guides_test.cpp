// What classical filters read, in files: ids, parts of radiance, the camera's matrices, cuts.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/file_io.h"
#include "frame/exr_reader.h"
#include "frame/frame_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/filter_guides.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

Frame read_back(const std::filesystem::path& path, Faults& faults) {
  return read_frame(path, {"id"}, faults);
}

TEST(FilterGuides, SurviveAFileToTheBit) {
  const TemporaryFolder folder;
  for (const auto& [width, height, spp] :
       {std::tuple(1, 1, 1), std::tuple(65, 3, 2), std::tuple(5, 130, 1)}) {
    const Frame frame = frame_with_filter_guides(width, height, spp);
    write_frame(folder / "a.exr", frame);
    Faults faults;
    const Frame read = read_back(folder / "a.exr", faults);
    EXPECT_FALSE(faults.any());
    EXPECT_EQ(read.features, feature_names());
    EXPECT_EQ(read.channels, kAllChannels);
    EXPECT_EQ(read.samples, frame.samples);
    EXPECT_EQ(read.info.world_to_camera, frame.info.world_to_camera);
    EXPECT_EQ(read.info.world_to_ndc, frame.info.world_to_ndc);
    EXPECT_TRUE(read.info.cut);
    write_frame(folder / "b.exr", read);
    EXPECT_EQ(read_file(folder / "a.exr"), read_file(folder / "b.exr"));
  }
}

TEST(FilterGuides, IdsAreExactUpToTwoToThe24) {
  const TemporaryFolder folder;
  Frame frame = frame_with_filter_guides(8, 1, 1);
  const std::vector<float> ids = {0, 1, 2049, 65505, 100001, 16777213, 16777215, kMostId};
  std::copy(ids.begin(), ids.end(), frame.plane(0, kIdOffset));
  write_frame(folder / "ids.exr", frame);
  Faults faults;
  const Frame read = read_back(folder / "ids.exr", faults);
  EXPECT_EQ(std::vector<float>(read.plane(0, kIdOffset), read.plane(0, kIdOffset) + 8), ids);
}

TEST(FilterGuides, AreReadOnlyWhereTheyAreThere) {
  const TemporaryFolder folder;
  Frame frame = frame_with_filter_guides(4, 3, 2);
  frame.features = {"radiance", "id"};
  frame.info.world_to_camera.reset();
  frame.info.cut = false;
  write_frame(folder / "some.exr", frame);
  Faults faults;
  const Frame read = read_back(folder / "some.exr", faults);
  EXPECT_EQ(read.features, frame.features);
  EXPECT_FALSE(read.info.world_to_camera);
  EXPECT_TRUE(read.info.world_to_ndc);
  EXPECT_FALSE(read.info.cut);
  EXPECT_EQ(read.plane(1, kDirectOffset)[5], 0);
  EXPECT_EQ(read.plane(1, kIdOffset)[5], frame.plane(1, kIdOffset)[5]);
  EXPECT_ERROR(read_frame(folder / "some.exr", {"direct"}, faults), "the feature 'direct' is needed");

  Frame without = random_frame(4, 3, 2);
  write_frame(folder / "none.exr", without);
  EXPECT_EQ(read_frame(folder / "none.exr", {}, faults).channels, kSampleChannels)
      << "and no memory for more";
  EXPECT_ERROR(read_back(folder / "none.exr", faults), "the feature 'id' is needed");
  without.features.emplace_back("id");
  EXPECT_ERROR(write_frame(folder / "none.exr", without), "expected 39 for its features");
}

TEST(FilterGuides, ChannelsOfIntegersThatAreCalledIdAreNoneOfOurs) {
  const TemporaryFolder folder;
  const std::string path = (folder / "integers.exr").string();
  Imf::Header header(2, 1);
  std::vector<uint32_t> ids = {7, 8};
  std::vector<float> radiance = {0.25F, 0.5F};
  Imf::FrameBuffer buffer;
  header.setName("s000");
  for (const char* name : {"R", "G", "B"}) {
    header.channels().insert(name, Imf::Channel(Imf::FLOAT));
    buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(radiance.data()), 4, 8));
  }
  header.channels().insert("id", Imf::Channel(Imf::UINT));
  buffer.insert("id", Imf::Slice(Imf::UINT, reinterpret_cast<char*>(ids.data()), 4, 8));
  {
    Imf::OutputFile file(path.c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(1);
  }
  Faults faults;
  const Frame frame = read_frame(path, {}, faults);
  EXPECT_EQ(frame.features, std::vector<std::string>{"radiance"});
  EXPECT_EQ(frame.plane(0, 0)[1], 0.5F);
}

TEST(FilterGuides, AreMendedLikeTheRest) {
  Frame frame = frame_with_filter_guides(6, 1, 1);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  frame.plane(0, kIdOffset)[0] = nan;
  frame.plane(0, kIdOffset)[1] = -3;
  frame.plane(0, kIdOffset)[2] = 1e30F;
  frame.plane(0, kDirectOffset + 1)[3] = -1;
  frame.plane(0, kDirectOffset)[4] = 3e38F;
  frame.plane(0, kFlowDepthOffset)[4] = 1e38F;
  frame.plane(0, 0)[5] = nan;
  const Faults faults = sanitise(frame);
  EXPECT_EQ(faults.guides, 1);
  EXPECT_EQ(faults.not_finite, 1);
  EXPECT_EQ(faults.negative, 0) << "of radiance";
  EXPECT_EQ(frame.plane(0, kIdOffset)[0], 0);
  EXPECT_EQ(frame.plane(0, kIdOffset)[1], 0);
  EXPECT_EQ(frame.plane(0, kIdOffset)[2], kMostId);
  EXPECT_EQ(frame.plane(0, kDirectOffset + 1)[3], 0);
  EXPECT_EQ(frame.plane(0, kDirectOffset)[4], 3e38F) << "light has no bound";
  EXPECT_EQ(frame.plane(0, kFlowDepthOffset)[4], kHalfMax);
  for (int c = 0; c < kAllChannels; ++c) EXPECT_EQ(frame.plane(0, c)[5], 0) << "masked, channel " << c;
}

TEST(FilterGuides, PartsAreDarkenedWithRadianceThatIsBeyondHalf) {
  const TemporaryFolder folder;
  Frame frame = frame_with_filter_guides(2, 1, 1);
  for (int c = 0; c < 3; ++c) {
    const float parts[3] = {200000, 60000.0F * static_cast<float>(c), 100};
    for (int k = 0; k < 3; ++k) frame.plane(0, kDirectOffset + 3 * k + c)[1] = parts[k];
    frame.plane(0, c)[1] = parts[0] + parts[1] + parts[2];
  }
  EXPECT_EQ(write_frame(folder / "bright.exr", frame), 3);
  Faults faults;
  const Frame read = read_back(folder / "bright.exr", faults);
  EXPECT_EQ(read.plane(0, 2)[1], kHalfMax);
  for (int c = 0; c < 3; ++c) {
    const float sum = read.plane(0, kDirectOffset + c)[1] + read.plane(0, kIndirectOffset + c)[1] +
                      read.plane(0, kEmissionOffset + c)[1];
    EXPECT_NEAR(sum / read.plane(0, c)[1], 1, 1e-3);
  }
  EXPECT_EQ(read.plane(0, kDirectOffset)[0], frame.plane(0, kDirectOffset)[0]);
}

TEST(CameraMatrices, AreOpenExrs) {
  // At (1, 2, 3), looking along +x, up is +z: right is -y.
  const CameraPlace place = {{1, 2, 3}, {0, -1, 0}, {0, 0, 1}, {-1, 0, 0}};
  const Matrix4 to_camera = world_to_camera(place);
  const auto moved = [&](double x, double y, double z, size_t c) {
    return x * to_camera[c] + y * to_camera[4 + c] + z * to_camera[8 + c] + to_camera[12 + c];
  };
  // 5 ahead, 1 to the right, 2 up.
  EXPECT_NEAR(moved(6, 1, 5, 0), 1, 1e-6);
  EXPECT_NEAR(moved(6, 1, 5, 1), 2, 1e-6);
  EXPECT_NEAR(moved(6, 1, 5, 2), 5, 1e-6) << "left-handed";
  const Matrix4 to_world = camera_to_world(to_camera);
  const double view[4] = {1, 2, -5, 1};
  for (size_t i = 0; i < 3; ++i) {
    double sum = 0;
    for (size_t k = 0; k < 4; ++k) sum += to_world[4 * i + k] * view[k];
    EXPECT_NEAR(sum, (std::array<double, 3>{6, 1, 5})[i], 1e-6);
  }
  const CameraPlace back = camera_place(to_camera);
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(back.position[i], place.position[i], 1e-6);
    EXPECT_NEAR(back.back[i], place.back[i], 1e-6);
  }
  // The picture reaches 0.8 to each side and 0.5 up and down at depth 1.
  const auto ndc = project_to_ndc(world_to_ndc(place, 0.8, 0.5), {6, 1, 5});
  EXPECT_NEAR(ndc[0], 0.5 + 0.5 * (1 / 5.0) / 0.8, 1e-6);
  EXPECT_NEAR(ndc[1], 0.5 - 0.5 * (2 / 5.0) / 0.5, 1e-6) << "+y is down";
  EXPECT_FALSE(std::isfinite(camera_place(Matrix4{}).position[0])) << "no inverse";
}

}  // namespace
}  // namespace ld
