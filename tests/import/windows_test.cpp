// Channels whose part has another data window than the samples'.
#include <gtest/gtest.h>

#include "core/file_io.h"
#include "import/frame_import.h"
#include "tests/support/expect_error.h"
#include "tests/support/exr_parts.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

const Imath::Box2i kDisplay({0, 0}, {19, 15}), kBeauty({4, 3}, {13, 10});

class Windows : public ::testing::Test {
 protected:
  /// Two samples whose matte, 1 + x + 100 y / 1000, and normals lie in these windows.
  std::vector<std::filesystem::path> files(const Imath::Box2i& matte, const Imath::Box2i& normals = kBeauty) {
    std::vector<std::filesystem::path> paths;
    for (const float red : {1.0F, 2.0F}) {
      paths.push_back(folder_ / (red == 1 ? "a.exr" : "b.exr"));
      write_exr_parts(
          paths.back(), kDisplay,
          {{"beauty", kBeauty, {{"R", everywhere(red)}, {"G", everywhere(0.5F)}, {"B", everywhere(0.25F)}}},
           {"N", normals, {{"N.X", everywhere(0)}, {"N.Y", everywhere(0)}, {"N.Z", everywhere(1)}}},
           {"matte", matte, {{"A", [](int x, int y) { return float(x + 100 * y) / 2000; }}}}});
    }
    return paths;
  }
  ImportMapping mapping() const {
    write_file_atomically(
        folder_ / "mapping.yaml",
        "radiance:\n  part: beauty\n  channels: [R, G, B]\nnormal:\n  part: N\n  channels: [N.X, N.Y, N.Z]\n"
        "alpha:\n  part: matte\n  channels: [A]\n");
    return read_mapping("", folder_ / "mapping.yaml", {});
  }

  TemporaryFolder folder_;
};

TEST_F(Windows, AMatteIsPlacedByItsOwn) {
  const Imath::Box2i mattes[] = {kBeauty,
                                 {{0, 0}, {19, 15}},         // larger
                                 {{6, 5}, {8, 7}},           // smaller
                                 {{10, 8}, {30, 40}},        // aside, and over the display's edge
                                 {{-50, -60}, {4, 3}},       // one pixel in common
                                 {{100, 100}, {101, 102}}};  // none
  for (const Imath::Box2i& matte : mattes) {
    const Frame frame = import_frame(files(matte), mapping(), std::nullopt, false).frame;
    ASSERT_EQ(frame.width, 10);
    ASSERT_EQ(frame.alpha.size(), 2u * 10 * 8);
    for (int s = 0; s < 2; ++s)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 10; ++x) {
          const Imath::V2i pixel(x + kBeauty.min.x, y + kBeauty.min.y);
          const float expected = matte.intersects(pixel) ? float(pixel.x + 100 * pixel.y) / 2000 : 0.0F;
          ASSERT_EQ(frame.alpha[size_t((s * 8 + y) * 10 + x)], expected)
              << pixel << " of " << matte.min << matte.max;
        }
    const ImportedPicture picture = import_picture(folder_ / "a.exr", mapping());
    ASSERT_EQ(picture.image.channels, 4);
    EXPECT_EQ(picture.image.at(3, 4, 4), frame.alpha[4 * 10 + 4]);
  }
}

TEST_F(Windows, GuidesArePlacedByTheirs) {
  for (const Imath::Box2i& normals : {kDisplay, Imath::Box2i({4, 3}, {13, 11}),
                                      Imath::Box2i({5, 3}, {14, 10}), Imath::Box2i({6, 5}, {8, 7})}) {
    const ImportedFrame imported = import_frame(files(kBeauty, normals), mapping(), std::nullopt, false);
    const Frame& frame = imported.frame;
    ASSERT_EQ(frame.width, 10);
    ASSERT_TRUE(frame.holds("normal"));
    for (int s = 0; s < 2; ++s)
      for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 10; ++x)
          ASSERT_EQ(frame.plane(s, kNormalOffset + 2)[y * 10 + x],
                    normals.intersects(Imath::V2i(x, y) + kBeauty.min) ? 1.0F : 0.0F)
              << x << " " << y << " of " << normals.min << normals.max;
    const bool covers = normals.intersects(kBeauty.min) && normals.intersects(kBeauty.max);
    ASSERT_EQ(imported.notes.size(), covers ? 0u : 1u);
    for (const std::string& note : imported.notes)
      EXPECT_NE(note.find("normal: its data window"), std::string::npos) << note;
  }
}

/// What is outside is no number that the mapping's scale, offset and kind could turn into a surface.
TEST_F(Windows, OutsideOfAGuideNothingWasHit) {
  const Imath::Box2i cropped({6, 5}, {8, 7});
  write_exr_parts(
      folder_ / "a.exr", kDisplay,
      {{"beauty", kBeauty, {{"R", everywhere(1)}, {"G", everywhere(1)}, {"B", everywhere(1)}}},
       {"N", cropped, {{"N.X", everywhere(0.5F)}, {"N.Y", everywhere(0.5F)}, {"N.Z", everywhere(1)}}},
       {"z", cropped, {{"Z", everywhere(0.5F)}}}});
  for (const char* depth :
       {"  kind: planar\n  offset: [1]\n", "  inverse: true\n", "  kind: planar\n  near: 2\n"}) {
    write_file_atomically(folder_ / "mapping.yaml",
                          std::string("radiance:\n  channels: [R, G, B]\n"
                                      "normal:\n  channels: [N.X, N.Y, N.Z]\n  scale: [2]\n  offset: [-1]\n"
                                      "depth:\n  channels: [Z]\n") +
                              depth);
    const Frame frame =
        import_frame({folder_ / "a.exr"}, read_mapping("", folder_ / "mapping.yaml", {}), std::nullopt, false)
            .frame;
    for (int y = 0; y < 8; ++y)
      for (int x = 0; x < 10; ++x) {
        const bool inside = cropped.intersects(Imath::V2i(x, y) + kBeauty.min);
        const int p = y * 10 + x;
        ASSERT_EQ(frame.plane(0, kNormalOffset)[p], 0.0F);
        ASSERT_EQ(frame.plane(0, kNormalOffset + 2)[p], inside ? 1.0F : 0.0F);
        ASSERT_EQ(frame.plane(0, kDepthOffset)[p] < kEscapedDepth, inside) << x << " " << y << " " << depth;
      }
    EXPECT_LT(frame.info.depth_scale, 3) << "of what was hit";
  }
}

TEST_F(Windows, AGuideOfAnotherPlaceIsLeftOut) {
  const ImportedFrame imported =
      import_frame(files(kBeauty, {{15, 12}, {19, 15}}), mapping(), std::nullopt, false);
  EXPECT_EQ(imported.frame.features, std::vector<std::string>{"radiance"});
  ASSERT_EQ(imported.notes.size(), 1u);
  EXPECT_NE(imported.notes[0].find("normal left out"), std::string::npos) << imported.notes[0];
}

TEST_F(Windows, RadianceOfSamplesIsPlacedByTheirs) {
  const Imath::Box2i first({4, 3}, {9, 10}), second({6, 1}, {13, 8});
  const auto write = [&](const char* name, const Imath::Box2i& window, float red,
                         const Imath::Box2i& display) {
    write_exr_parts(
        folder_ / name, display,
        {{"beauty",
          window,
          {{"R", everywhere(red)}, {"G", everywhere(1)}, {"B", everywhere(1)}, {"A", everywhere(1)}}}});
  };
  write_file_atomically(folder_ / "mapping.yaml",
                        "radiance:\n  channels: [R, G, B]\nalpha:\n  channels: [A]\n");
  const ImportMapping own = read_mapping("", folder_ / "mapping.yaml", {});
  write("a.exr", first, 1, kDisplay);
  write("b.exr", second, 2, kDisplay);
  const ImportedFrame imported =
      import_frame({folder_ / "a.exr", folder_ / "b.exr"}, own, std::nullopt, false);
  const Frame& frame = imported.frame;
  ASSERT_EQ(frame.width, 10);
  ASSERT_EQ(frame.height, 10);
  EXPECT_EQ(frame.info.windows.x, 4);
  EXPECT_EQ(frame.info.windows.y, 1);
  EXPECT_EQ(frame.info.windows.display_right, 19);
  for (int s = 0; s < 2; ++s)
    for (int p = 0; p < 100; ++p) {
      const bool inside = (s == 0 ? first : second).intersects(Imath::V2i(4 + p % 10, 1 + p / 10));
      ASSERT_EQ(frame.plane(s, 0)[p], inside ? float(s + 1) : 0.0F) << s << " " << p;
      ASSERT_EQ(frame.alpha[size_t(s * 100 + p)], inside ? 1.0F : 0.0F) << s << " " << p;
      ASSERT_EQ(frame.valid_plane(s)[p], 1);
    }
  ASSERT_EQ(imported.notes.size(), 1u);
  EXPECT_NE(imported.notes[0].find("radiance: its data window"), std::string::npos) << imported.notes[0];

  write("b.exr", second, 2, {{0, 0}, {39, 31}});
  EXPECT_ERROR(import_frame({folder_ / "a.exr", folder_ / "b.exr"}, own, std::nullopt, false),
               "display window");
  const int far = 1 << 20;
  write("b.exr", {{far, far}, {far + 3, far + 3}}, 2, kDisplay);
  EXPECT_ERROR(import_frame({folder_ / "a.exr", folder_ / "b.exr"}, own, std::nullopt, false), "b.exr");
}

}  // namespace
}  // namespace ld
