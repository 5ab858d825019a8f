#include "import/convert.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/file_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

using Planes = std::vector<std::vector<float>>;

FeatureMapping mapping_of(const std::string& feature, size_t components, const std::string& kind = "") {
  FeatureMapping mapping;
  mapping.feature = feature;
  mapping.kind = kind;
  mapping.channels.assign(components, "X");
  mapping.scale.assign(components, 1);
  mapping.offset.assign(components, 0);
  return mapping;
}

/// Stands at (10, 20, 30) and looks along the world's +x; the world's +z is up. So the world's -y is right.
ViewCamera along_x() {
  ViewCamera camera;
  camera.right = {0, -1, 0};
  camera.up = {0, 0, 1};
  camera.back = {-1, 0, 0};
  camera.position = {10, 20, 30};
  camera.fov_y = 2 * std::atan(0.75);  // the picture of 4 x 3 reaches to x = 1, y = 0.75 at z = -1
  camera.origin = "camera";
  return camera;
}

Planes convert(const FeatureMapping& mapping, const Planes& channels,
               const std::optional<ViewCamera>& camera = std::nullopt) {
  return Converter(4, 3, {}, camera).convert(mapping, channels);
}

Planes constant(const std::vector<float>& values) {
  Planes planes;
  for (const float value : values) planes.emplace_back(12, value);
  return planes;
}

void expect_pixel(const Planes& planes, size_t pixel, const std::vector<float>& expected) {
  ASSERT_EQ(planes.size(), expected.size());
  for (size_t c = 0; c < expected.size(); ++c)
    EXPECT_NEAR(planes[c][pixel], expected[c], 1e-5F * std::max(1.0F, std::abs(expected[c])))
        << "component " << c;
}

TEST(Convert, ScaleAndOffsetComeFirst) {
  FeatureMapping lens = mapping_of("lens", 2);  // from [0, 1], y down
  lens.scale = {2, -2};
  lens.offset = {-1, 1};
  expect_pixel(convert(lens, constant({0.75F, 0.25F})), 3, {0.5F, 0.5F});
  FeatureMapping time = mapping_of("time", 1);  // frames 12.25 to 12.75
  time.scale = {2};
  time.offset = {-24.5};
  expect_pixel(convert(time, constant({12.5F})), 0, {0.5F});
}

TEST(Convert, NormalsToViewSpace) {
  FeatureMapping normal = mapping_of("normal", 3);
  expect_pixel(convert(normal, constant({0, 0, 2})), 0, {0, 0, 1});  // made unit vectors
  expect_pixel(convert(normal, constant({0, 0, 0})), 0, {0, 0, 0});  // but those of rays that escaped
  normal.space = "view_z_forward";
  expect_pixel(convert(normal, constant({0.6F, 0, -0.8F})), 5, {0.6F, 0, 0.8F});
  normal.space = "world";
  expect_pixel(convert(normal, constant({-0.8F, 0, 0.6F}), along_x()), 5, {0, 0.6F, 0.8F});
  expect_pixel(convert(normal, constant({0, 1, 0}), along_x()), 5, {-1, 0, 0});
  EXPECT_ERROR(convert(normal, constant({0, 1, 0})), "give --camera FILE.yaml");
  normal.face_camera = true;
  expect_pixel(convert(normal, constant({0.8F, 0, -0.6F}), along_x()), 5, {0, 0.6F, 0.8F});
  expect_pixel(convert(normal, constant({-0.8F, 0, 0.6F}), along_x()), 5, {0, 0.6F, 0.8F});
}

TEST(Convert, DepthAlongTheAxis) {
  FeatureMapping depth = mapping_of("depth", 1, "planar");
  depth.scale = {0.01};
  expect_pixel(convert(depth, constant({250})), 0, {2.5F});
  depth.escaped_above = 1e9;
  Planes planes = constant({250});
  planes[0][1] = 1e10F;
  planes[0][2] = std::numeric_limits<float>::infinity();
  planes[0][3] = 1e8F;  // 1e6 in scene units: half floats end before
  Converter converter(4, 3, {}, std::nullopt);
  const Planes result = converter.convert(depth, planes);
  EXPECT_EQ(result[0][1], kEscapedDepth);
  EXPECT_EQ(result[0][2], kEscapedDepth);
  EXPECT_EQ(result[0][3], kEscapedDepth);
  EXPECT_EQ(converter.counts().beyond_half, 1);

  FeatureMapping inverse = mapping_of("depth", 1, "planar");
  inverse.inverse = true;
  expect_pixel(convert(inverse, constant({0.25F})), 0, {4});
  expect_pixel(convert(inverse, constant({0})), 0, {kEscapedDepth});
}

TEST(Convert, DistancesNeedTheRay) {
  FeatureMapping depth = mapping_of("depth", 1, "distance");
  depth.escaped_at = {0};
  // The middle of pixel (0, 0) lies at (-0.75, 0.5, -1) in view space.
  const float length = std::sqrt(0.75F * 0.75F + 0.5F * 0.5F + 1);
  expect_pixel(convert(depth, constant({3}), along_x()), 0, {3 / length});
  expect_pixel(convert(depth, constant({0}), along_x()), 0, {kEscapedDepth});
  depth.near = 0.25;
  expect_pixel(convert(depth, constant({3}), along_x()), 0, {3 / length + 0.25F});
  ViewCamera blind = along_x();
  blind.fov_y.reset();
  EXPECT_ERROR(convert(depth, constant({3}), blind), "no field of view");
  EXPECT_ERROR(convert(depth, constant({3})), "needs the camera");

  // The same pixels as the lower right part of a picture twice as large, at the same angle.
  Windows windows;
  windows.x = 4;
  windows.y = 3;
  windows.display_right = 7;
  windows.display_bottom = 5;
  depth.near = 0;
  const Planes cropped = Converter(4, 3, windows, along_x()).convert(depth, constant({3}));
  const float closer = std::sqrt(0.125F * 0.125F + 0.125F * 0.125F + 1);
  expect_pixel(cropped, 0, {3 / closer});
}

TEST(Convert, DepthFromPositions) {
  FeatureMapping depth = mapping_of("depth", 3, "view_position");
  depth.escaped_at = {0};
  expect_pixel(convert(depth, constant({1, 2, -5})), 0, {5});
  expect_pixel(convert(depth, constant({0, 0, 0})), 0, {kEscapedDepth});
  expect_pixel(convert(depth, constant({1, 0, -2})), 0, {2});
  depth.kind = "view_position_z_forward";
  expect_pixel(convert(depth, constant({1, 2, 5})), 0, {5});
  depth.kind = "world_position";
  expect_pixel(convert(depth, constant({17, -3, 4}), along_x()), 0, {7});
}

TEST(Convert, MovementInPixelsAndYDown) {
  FeatureMapping flow = mapping_of("flow", 2);
  expect_pixel(convert(flow, constant({3, -2})), 0, {3, -2});
  flow.unit = "ndc";  // the picture is 4 x 3: its corner (1, 1) is 2 pixels right and 1.5 up of the middle
  expect_pixel(convert(flow, constant({1, 1})), 0, {2, -1.5F});
  flow.unit = "picture";
  expect_pixel(convert(flow, constant({0.5F, 0.5F})), 0, {2, 1.5F});
}

TEST(Convert, RoughnessAndColours) {
  expect_pixel(convert(mapping_of("roughness", 1, "alpha"), constant({0.09F})), 0, {0.3F});
  expect_pixel(convert(mapping_of("roughness", 1, "roughness"), constant({0.09F})), 0, {0.09F});
  FeatureMapping albedo = mapping_of("albedo", 3);
  albedo.maximum = 1;
  Converter converter(4, 3, {}, std::nullopt);
  expect_pixel(converter.convert(albedo, constant({1.5F, 0.25F, 1})), 0, {1, 0.25F, 1});
  EXPECT_EQ(converter.counts().above_maximum, 12);
}

ViewCamera camera_from(const std::string& yaml) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "camera.yaml", yaml);
  return read_camera(folder / "camera.yaml");
}

void expect_vector(const Imath::V3d& found, const Imath::V3d& expected) {
  EXPECT_NEAR((found - expected).length(), 0, 1e-9) << found << " instead of " << expected;
}

TEST(ViewCamera, FromAMatrixOrFromWhereItLooks) {
  const ViewCamera matrix = camera_from(
      "camera_to_world: [[0, 0, -2, 10], [-2, 0, 0, 20], [0, 2, 0, 30], [0, 0, 0, 1]]\nfov_y: 0.5\n");
  const ViewCamera target =
      camera_from("position: [10, 20, 30]\nlook_at: [15, 20, 30]\nup: [0, 0, 1]\nwidth: 4\n");
  for (const ViewCamera& camera : {matrix, target}) {
    expect_vector(camera.right, along_x().right);
    expect_vector(camera.up, along_x().up);
    expect_vector(camera.back, along_x().back);
    expect_vector(camera.point_to_view({15, 19, 32}), {1, 2, -5});
  }
  EXPECT_EQ(matrix.fov_y, 0.5);
  EXPECT_FALSE(target.fov_y);
  EXPECT_ERROR(camera_from("fov_y: 0.5\n"), "either camera_to_world or position");
  EXPECT_ERROR(camera_from("camera_to_world: [1, 2, 3]\n"), "3 numbers");
  EXPECT_ERROR(camera_from("camera_to_world: [[1,0,0,0],[0,1,0,0],[0,0,-1,0],[0,0,0,1]]\n"), "left-handed");
  EXPECT_ERROR(camera_from("camera_to_world: [[1,0,0,0],[0,2,0,0],[0,0,1,0],[0,0,0,1]]\n"), "equal ones");
  EXPECT_ERROR(camera_from("camera_to_world: [[1,0.6,0,0],[0,0.8,0,0],[0,0,1,0],[0,0,0,1]]\n"),
               "right angles");
  EXPECT_ERROR(camera_from("position: [0, 0, 0]\nlook_at: [0, 3, 0]\n"), "looks along `up`");
  ViewCamera other = along_x();
  other.width = 8;
  other.height = 3;
  EXPECT_ERROR(Converter(4, 3, {}, other), "a camera for 8 x 3 pixels, but the picture has 4 x 3");
}

}  // namespace
}  // namespace ld
