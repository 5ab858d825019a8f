// The presets of renderers of which no file was at hand, on files in the layout that their documentation
// describes: which channels are taken for what, in which space and with which sign.
#include <gtest/gtest.h>

#include "core/file_io.h"
#include "import/frame_import.h"
#include "import/recognise.h"
#include "tests/support/exr_parts.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

using Values = std::vector<std::pair<std::string, float>>;

const Values kPicture = {{"R", 0.5F}, {"G", 0.5F}, {"B", 0.5F}, {"A", 1}};

Values xyz(const std::string& layer, const std::string& suffixes, float x, float y, float z) {
  return {{layer + "." + suffixes[0], x}, {layer + "." + suffixes[1], y}, {layer + "." + suffixes[2], z}};
}

/// A camera at (1, 0, 10) that looks along the world's -x: its right is the world's -z.
const char* const kCamera = "position: [1, 0, 10]\nlook_at: [0, 0, 10]\nfov_y: 0.5\n";

class PresetLayouts : public ::testing::Test {
 protected:
  /// The frame that a file of these channels makes, with the preset that it is recognised as.
  Frame import_as(const std::string& preset, const std::vector<Values>& layers) {
    TestPart part{"rgba", Imath::Box2i({0, 0}, {0, 0}), {}};
    for (const Values& layer : layers)
      for (const auto& [name, value] : layer) part.channels.emplace_back(name, everywhere(value));
    write_exr_parts(folder_ / "file.exr", part.window, {part});
    write_file_atomically(folder_ / "camera.yaml", kCamera);
    EXPECT_EQ(recognise_preset(ExrReader(folder_ / "file.exr")), preset);
    return import_frame({folder_ / "file.exr"}, read_mapping(preset, "", {}),
                        read_camera(folder_ / "camera.yaml"), false)
        .frame;
  }

  static void expect(const Frame& frame, const std::string& feature, const std::vector<float>& expected) {
    ASSERT_TRUE(frame.holds(feature)) << feature;
    for (size_t c = 0; c < expected.size(); ++c)
      EXPECT_NEAR(frame.plane(0, find_feature(feature).offset + static_cast<int>(c))[0], expected[c], 1e-6F)
          << feature << ", component " << c;
  }

  TemporaryFolder folder_;
};

TEST_F(PresetLayouts, CyclesNumbersObjects) {
  const auto layer = [](const std::string& pass, float value) {
    return Values{{"ViewLayer.Combined.R", 0.5F}, {"ViewLayer.Combined.G", 0.5F},
                  {"ViewLayer.Combined.B", 0.5F}, {"ViewLayer.Combined.A", 1},
                  {"ViewLayer.Depth.Z", 4},       {"ViewLayer." + pass, value}};
  };
  const Frame frame = import_as("cycles", {layer("IndexOB.X", 70000)});
  expect(frame, "id", {70000});
  ASSERT_TRUE(frame.info.world_to_camera && frame.info.world_to_ndc);
  const Matrix4 to_world = camera_to_world(*frame.info.world_to_camera);
  const std::array<float, 3> position = {1, 0, 10}, back = {1, 0, 0};
  for (size_t i = 0; i < 3; ++i) {
    EXPECT_NEAR(to_world[4 * i + 3], position[i], 1e-5);
    EXPECT_NEAR(to_world[4 * i + 2], back[i], 1e-6);
  }
  expect(import_as("cycles", {layer("Object Index.X", 3)}), "id", {3});
  EXPECT_FALSE(import_as("cycles", {layer("IndexOB.X", 0)}).holds("id")) << "nobody numbered the objects";
}

// The world's +x is towards this camera, +y its up, -z its right. Of a point at x = -4 the depth is 5.
TEST_F(PresetLayouts, KarmaInWorldSpace) {
  const Values albedo = xyz("albedo", "RGB", 0.25F, 0.5F, 1.5F);
  const Values normal = xyz("N", "xyz", 0.8F, 0, -0.6F);
  for (const Values& depth : {Values{{"hitPz", 5}}, Values{{"hitPz.z", 5}}, xyz("P", "xyz", -4, 0, 10)}) {
    const Frame frame = import_as("karma", {kPicture, albedo, normal, depth});
    expect(frame, "normal", {0.6F, 0, 0.8F});
    expect(frame, "depth", {5});
    expect(frame, "albedo", {0.25F, 0.5F, 1});
  }
  expect(import_as("karma", {kPicture, xyz("hitN", "xyz", -0.8F, 0, 0.6F)}), "normal", {0.6F, 0, 0.8F});
}

TEST_F(PresetLayouts, RenderManInWorldSpace) {
  const Frame frame =
      import_as("renderman", {kPicture, xyz("__Nworld", "rgb", -0.8F, 0, 0.6F),
                              xyz("__Pworld", "rgb", -4, 0, 10), xyz("albedo", "rgb", 0.25F, 0.5F, 1.5F)});
  expect(frame, "normal", {0.6F, 0, 0.8F});  // turned towards the camera
  expect(frame, "depth", {5});
  expect(frame, "albedo", {0.25F, 0.5F, 1});
}

TEST_F(PresetLayouts, VRayInCameraSpace) {
  for (const char* suffixes : {"XYZ", "RGB"}) {
    const Frame frame =
        import_as("vray", {kPicture, xyz("VRayNormals", suffixes, 0.6F, 0, 0.8F), Values{{"Z", 5}},
                           xyz("VRayDiffuseFilter", "RGB", 0.25F, 0.5F, 1.5F),
                           xyz("VRayReflectionFilter", "RGB", 0.125F, 0, 0)});
    expect(frame, "normal", {0.6F, 0, 0.8F});
    expect(frame, "depth", {5});
    expect(frame, "albedo", {0.25F, 0.5F, 1});
    expect(frame, "specular", {0.125F, 0, 0});
  }
}

// By these names others write diffuse light, and depths and normals of every kind.
TEST_F(PresetLayouts, CommonNamesAreNobodys) {
  const Frame frame = import_as("mitsuba", {kPicture, xyz("normals", "XYZ", 0, 0, 1), Values{{"Z", 5}},
                                            Values{{"depth.Z", 5}, {"diffuse.red", 1}}});
  EXPECT_EQ(frame.features, std::vector<std::string>{"radiance"});
}

TEST_F(PresetLayouts, ArnoldInWorldSpace) {
  const Frame frame =
      import_as("arnold", {kPicture, xyz("N", "XYZ", -0.8F, 0, 0.6F), xyz("P", "XYZ", -4, 0, 10),
                           xyz("diffuse_albedo", "RGB", 0.25F, 0.5F, 1)});
  expect(frame, "normal", {0.6F, 0, 0.8F});
  expect(frame, "depth", {5});
}

}  // namespace
}  // namespace ld
