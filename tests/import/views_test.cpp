// Stereo and multi-view files: which channels are whose, in both of OpenEXR's conventions, and in the files
// that Blender 4.5 and 5.0 wrote (tests/fixtures/import).
#include <ImfMatrixAttribute.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>

#include "import/file_views.h"
#include "import/frame_import.h"
#include "import/recognise.h"
#include "tests/support/expect_error.h"
#include "tests/support/exr_parts.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;
const Imath::Box2i kWindow({0, 0}, {3, 2});

TestChannels operator+(TestChannels a, const TestChannels& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

ImportMapping mapping_of(const std::string& preset, const std::string& view) {
  ImportMapping mapping = read_mapping(preset, "", {});
  mapping.view = view;
  return mapping;
}

ImportedFrame import_view(const std::vector<fs::path>& files, const std::string& view,
                          const std::string& preset = "mitsuba") {
  return import_frame(files, mapping_of(preset, view), std::nullopt, false);
}

float value(const Frame& frame, const std::string& feature) {
  return frame.plane(0, find_feature(feature).offset)[0];
}

class Views : public ::testing::Test {
 protected:
  /// One part, views left and right: those of the hero have no view in their names.
  fs::path one_part(const TestChannels& more = {}) {
    write_exr_parts(
        folder_ / "one.exr", kWindow,
        {{"rgba", kWindow, colour("", 1) + colour("right.", 2) + colour("albedo.", 0.25F) + more}},
        {"left", "right"});
    return folder_ / "one.exr";
  }

  TemporaryFolder folder_;
};

TEST_F(Views, TheHeroIsReadWhereNobodyAsks) {
  const ImportedFrame left = import_view({one_part()}, "");
  EXPECT_EQ(value(left.frame, "radiance"), 1);
  EXPECT_EQ(value(left.frame, "albedo"), 0.25F);
  EXPECT_EQ(left.view, "left");
  EXPECT_EQ(left.view_text, "view: left, of left, right; --view NAME takes another");
  EXPECT_TRUE(left.unused.empty()) << "another view's channels are no oversight";
  EXPECT_EQ(recognise_preset(ExrReader(one_part()), "right"), "mitsuba");
}

TEST_F(Views, AnotherViewHasItsOwnChannelsOnly) {
  const ImportedFrame right = import_view({one_part()}, "right");
  EXPECT_EQ(value(right.frame, "radiance"), 2);
  EXPECT_FALSE(right.frame.holds("albedo")) << "albedo.* is the hero's";
  const ImportedFrame whole = import_view({one_part(colour("albedo.right.", 0.75F))}, "right");
  EXPECT_EQ(value(whole.frame, "albedo"), 0.75F);
}

TEST_F(Views, PartsSayWhoseTheyAre) {
  write_exr_parts(folder_ / "parts.exr", kWindow,
                  {{"rgb.right", kWindow, colour("", 2), "right"},
                   {"albedo-right", kWindow, colour("", 0.5F), "right"},
                   {"rgb.left", kWindow, colour("", 1), "left"},
                   {"albedo-left", kWindow, colour("albedo.", 0.25F), "left"}});
  // The first part's channels are called as the second's: its name tells which are the albedo.
  ImportMapping mapping = mapping_of("mitsuba", "");
  mapping.features[0].part = "rgb*";
  const ImportedFrame hero = import_frame({folder_ / "parts.exr"}, mapping, std::nullopt, false);
  EXPECT_EQ(hero.view, "right");
  EXPECT_EQ(value(hero.frame, "radiance"), 2);
  EXPECT_EQ(value(hero.frame, "albedo"), 0.5F);
  const ImportedFrame left = import_view({folder_ / "parts.exr"}, "left");
  EXPECT_EQ(value(left.frame, "radiance"), 1);
  EXPECT_EQ(value(left.frame, "albedo"), 0.25F);
}

TEST_F(Views, BlendersStereoFiles) {
  for (const char* folder : {"cycles", "cycles5"}) {
    const fs::path file = kImportFixtures / folder / "stereo.exr";
    EXPECT_EQ(FileViews(ExrReader(file), "").all(), (std::vector<std::string>{"left", "right"}));
    EXPECT_EQ(recognise_preset(ExrReader(file), "right"), "cycles");
    // The right camera stands 0.4 to the right: n . p of the plane (README.md) is smaller by 0.36 * 0.4.
    for (const auto& [view, depth] : {std::pair{"left", 4.3649F}, {"right", 4.3649F * 4.576F / 4.432F}}) {
      const Frame frame = import_frame({file}, mapping_of("cycles", view),
                                       read_camera(kImportFixtures / "cycles/camera.yaml"), false)
                              .frame;
      const size_t plane = 8 * 16 + 1;
      EXPECT_NEAR(frame.plane(0, kDepthOffset)[plane], depth, 1e-3F) << folder << " " << view;
      EXPECT_NEAR(frame.plane(0, kNormalOffset + 1)[plane], 0.48F, 1e-3F);
      EXPECT_EQ(frame.features,
                (std::vector<std::string>{"radiance", "normal", "depth", "albedo", "specular", "flow"}));
    }
  }
}

TEST_F(Views, AllFilesAreReadFromOneView) {
  write_exr_parts(folder_ / "other.exr", kWindow,
                  {{"rgba", kWindow, colour("", 3) + colour("left.", 4) + colour("albedo.left.", 0.5F)}},
                  {"right", "left"});
  const ImportedFrame both = import_view({one_part(), folder_ / "other.exr"}, "");
  EXPECT_EQ(both.frame.plane(1, kRadianceOffset)[0], 4) << "left, as in the first file";
}

TEST_F(Views, UnknownViewsAreNamedWithThoseThatThereAre) {
  const std::string text = error_text([&] { import_view({one_part()}, "centre"); });
  EXPECT_NE(text.find("no view 'centre'; the file has left, right"), std::string::npos) << text;
  EXPECT_THROW(import_view({one_part()}, "centre"), UsageError);
  write_exr_parts(folder_ / "mono.exr", kWindow, {{"rgba", kWindow, colour("", 1)}});
  EXPECT_ERROR(import_view({folder_ / "mono.exr"}, "left"), "the file says nothing of views");
  EXPECT_EQ(import_view({folder_ / "mono.exr"}, "").view, "");
}

TEST_F(Views, WhatNoWriterMeansIsStillReadInOneWay) {
  // The first part says nothing: it is the hero, without a name.
  write_exr_parts(folder_ / "late.exr", kWindow,
                  {{"rgb", kWindow, colour("", 1)}, {"rgb.right", kWindow, colour("", 2), "right"}});
  EXPECT_EQ(value(import_view({folder_ / "late.exr"}, "").frame, "radiance"), 1);
  EXPECT_EQ(value(import_view({folder_ / "late.exr"}, "right").frame, "radiance"), 2);
  EXPECT_ERROR(import_view({folder_ / "late.exr"}, "left"), "one without a name, right");
  write_exr_parts(folder_ / "many.exr", kWindow, {{"rgba", kWindow, colour("", 1)}},
                  std::vector<std::string>(300, "view"));
  EXPECT_ERROR(import_view({folder_ / "many.exr"}, ""), "300 views");
  // A part's own word counts more than a list for all parts.
  write_exr_parts(folder_ / "both.exr", kWindow,
                  {{"a", kWindow, colour("", 1), "left"}, {"b", kWindow, colour("", 2), "right"}},
                  {"centre", "left"});
  EXPECT_EQ(import_view({folder_ / "both.exr"}, "").view, "left");
}

TEST_F(Views, AReferenceMayHaveNoViews) {
  EXPECT_EQ(import_picture(one_part(), mapping_of("mitsuba", "right")).image.pixels[0], 2);
  write_exr_parts(folder_ / "mono.exr", kWindow, {{"rgba", kWindow, colour("", 3)}});
  EXPECT_EQ(import_picture(folder_ / "mono.exr", mapping_of("mitsuba", "right")).image.pixels[0], 3);
}

TEST_F(Views, OnePartsCameraIsTheHeros) {
  {
    Imf::Header header(2, 1);
    Imf::addMultiView(header, {"left", "right"});
    header.insert("worldToCamera",
                  Imf::M44fAttribute(Imath::M44f(1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -10, 1)));
    header.channels().insert("R", Imf::Channel(Imf::FLOAT));
    const std::vector<float> pixels(2);
    Imf::FrameBuffer buffer;
    buffer.insert("R", Imf::Slice::Make(Imf::FLOAT, pixels.data(), header.dataWindow()));
    Imf::OutputFile file((folder_ / "camera.exr").c_str(), header);
    file.setFrameBuffer(buffer);
    file.writePixels(1);
  }
  const ExrReader exr(folder_ / "camera.exr");
  ASSERT_TRUE(FileViews(exr, "").camera());
  EXPECT_EQ(FileViews(exr, "left").camera()->position, Imath::V3d(0, 0, 10));
  EXPECT_FALSE(FileViews(exr, "right").camera());
}

}  // namespace
}  // namespace ld
