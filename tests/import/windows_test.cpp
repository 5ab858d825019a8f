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

TEST_F(Windows, GuidesMustHaveThatOfTheSamples) {
  for (const Imath::Box2i& normals :
       {Imath::Box2i({0, 0}, {19, 15}), Imath::Box2i({4, 3}, {13, 11}), Imath::Box2i({5, 3}, {14, 10})})
    EXPECT_ERROR(import_frame(files(kBeauty, normals), mapping(), std::nullopt, false), "channel 'N.X'");
}

}  // namespace
}  // namespace ld
