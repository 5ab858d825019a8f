// Features that follow from what lies beside a frame's file.
#include "frame/derived_features.h"

#include <gtest/gtest.h>

#include <cmath>

#include "frame/encoding.h"
#include "frame/frame_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

Frame read_with(const std::filesystem::path& path, const std::vector<std::string>& features) {
  Faults faults;
  return read_frame(path, features, faults);
}

TEST(DerivedFeatures, HalfRadianceIsTheCompanionsSampleAtEveryPixelOfFour) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair(7, 5), std::pair(8, 6), std::pair(1, 1)}) {
    const Frame frame = random_frame(width, height, 2, 3);
    Frame half = random_frame((width + 1) / 2, (height + 1) / 2, 3, 4);
    half.valid_plane(1)[0] = 0;  // the mean of the others stands in
    sanitise(half);
    write_frame(folder / "a.exr", frame);
    write_frame(folder / "a.half.exr", half);
    EXPECT_EQ(read_frame_header(folder / "a.exr").derivable, (std::vector<std::string>{"half_radiance"}));
    const Frame read = read_with(folder / "a.exr", {"half_radiance", "normal"});
    ASSERT_TRUE(read.holds("half_radiance"));
    const Image mean = mean_radiance(half);
    for (int s = 0; s < 2; ++s)
      for (int c = 0; c < 3; ++c)
        for (int y = 0; y < height; ++y)
          for (int x = 0; x < width; ++x) {
            const size_t p = size_t(y / 2 * half.width + x / 2);
            const float expected = half.valid_plane(s)[p] != 0 ? half.plane(s, c)[p] : mean.plane(c)[p];
            ASSERT_FLOAT_EQ(read.plane(s, kHalfRadianceOffset + c)[y * width + x], expected);
            ASSERT_EQ(read.plane(s, c)[y * width + x], frame.plane(s, c)[y * width + x]);
          }
    EXPECT_FALSE(read_with(folder / "a.exr", {"normal"}).holds("half_radiance")) << "unless it is wanted";
  }
}

TEST(DerivedFeatures, ACompanionThatDoesNotFitIsNamed) {
  const TemporaryFolder folder;
  write_frame(folder / "a.exr", random_frame(8, 6, 2));
  EXPECT_ERROR(read_with(folder / "a.exr", {"half_radiance"}), "half_radiance");
  write_frame(folder / "a.half.exr", random_frame(4, 4, 2));
  EXPECT_ERROR(read_with(folder / "a.exr", {"half_radiance"}), "expected 4 x 3 with 2 or more");
  write_frame(folder / "a.half.exr", random_frame(4, 3, 1));
  EXPECT_ERROR(read_with(folder / "a.exr", {"half_radiance"}), "with 1 samples");
}

TEST(DerivedFeatures, PositionIsWhereTheCameraSeesThePixelAtItsDepth) {
  const TemporaryFolder folder;
  Frame frame = random_frame(6, 4, 1, 3);
  // A camera that stands aside and looks askance, 90 degrees wide.
  const double s = std::sqrt(0.5);
  const CameraPlace camera = {{3, -2, 5}, {s, 0, -s}, {0, 1, 0}, {s, 0, s}};
  frame.info.world_to_camera = world_to_camera(camera);
  frame.info.world_to_ndc = world_to_ndc(camera, 1.5, 1);
  frame.plane(0, kDepthOffset)[5] = kEscapedDepth;
  write_frame(folder / "a.exr", frame);
  const Frame read = read_with(folder / "a.exr", {"position"});
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 6; ++x) {
      const int p = 6 * y + x;
      const float d = frame.plane(0, kDepthOffset)[p];
      const double expected[3] = {d * 1.5 * (2 * (x + 0.5) / 6 - 1), d * (1 - 2 * (y + 0.5) / 4), -d};
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(read.plane(0, kPositionOffset + c)[p], std::clamp(expected[c], -65504.0, 65504.0),
                    1e-4 * d)
            << c << " at " << x << ", " << y;
    }
  // As a network sees it: by the depth scale, bounded, and the same in other units.
  const Feature& position = find_feature("position");
  float near[2] = {-3, 65504}, far[2] = {-3000, 65504}, one[2], other[2];
  encode(position, 3, near, one, 2);
  encode(position, 3000, far, other, 2);
  EXPECT_FLOAT_EQ(one[0], -0.5F);
  EXPECT_FLOAT_EQ(other[0], -0.5F);
  EXPECT_LT(one[1], 1);
  frame.info.world_to_ndc.reset();
  write_frame(folder / "a.exr", frame);
  EXPECT_ERROR(read_with(folder / "a.exr", {"position"}), "the feature 'position' is needed");
}

}  // namespace
}  // namespace ld
