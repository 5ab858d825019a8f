#include <gtest/gtest.h>

#include <OpenImageIO/imageio.h>

#include <cmath>
#include <limits>

#include "core/file_io.h"
#include "core/tone_map.h"
#include "frame/frame_file.h"
#include "frame/picture_place.h"
#include "tests/support/expect_error.h"
#include "tests/support/exr_parts.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

Image ramp(int width, int height, int channels) {
  Image image(width, height, channels);
  for (size_t i = 0; i < image.pixels.size(); ++i) image.pixels[i] = static_cast<float>(i) / 8.0F;
  return image;
}

TEST(ImageFile, ExrRoundTrip) {
  const TemporaryFolder folder;
  for (const auto& [width, height] : {std::pair{1, 1}, std::pair{7, 1}, std::pair{33, 20}}) {
    const Image image = ramp(width, height, 3);
    write_image(folder / "image.exr", image);
    int64_t bad = -1;
    const Image read = read_image(folder / "image.exr", &bad);
    EXPECT_EQ(bad, 0);
    EXPECT_EQ(read.width, width);
    EXPECT_EQ(read.height, height);
    EXPECT_EQ(read.pixels, image.pixels);
  }
}

TEST(ImageFile, KeepsTheFloorOfAReference) {
  const TemporaryFolder folder;
  const Image image = ramp(5, 4, 3);
  const ReferenceFloor floor = {{"psnr", std::numeric_limits<double>::infinity()}, {"relmse", 1.25e-7}};
  write_image(folder / "with.exr", image, {}, floor);
  write_image(folder / "without.exr", image);
  const auto read = [&](const char* name) {
    return read_reference(folder / name, read_place(folder / name), "the frame");
  };
  EXPECT_EQ(read("with.exr").image.pixels, image.pixels);
  EXPECT_EQ(read("with.exr").floor, floor);
  EXPECT_TRUE(read("without.exr").floor.empty());
  write_image(folder / "wrong.exr", image, {}, {{"ssim", std::nan("")}});
  EXPECT_ERROR(read("wrong.exr"), "'ldFloor.ssim' is not a number");
  EXPECT_EQ(read_image(folder / "wrong.exr").width, 5) << "who does not ask for it does not mind";
}

TEST(ImageFile, SetsBadPixelsToZeroAndCountsThem) {
  const TemporaryFolder folder;
  Image image = ramp(4, 1, 3);
  image.at(0, 0, 0) = -1;
  image.at(1, 1, 0) = std::numeric_limits<float>::quiet_NaN();
  image.at(2, 2, 0) = 1e30F;  // clamped to half's range when written
  write_image(folder / "image.exr", image);
  int64_t bad = -1;
  const Image read = read_image(folder / "image.exr", &bad);
  EXPECT_EQ(bad, 2);
  EXPECT_EQ(read.at(0, 0, 0), 0.0F);
  EXPECT_EQ(read.at(1, 1, 0), 0.0F);
  EXPECT_EQ(read.at(2, 2, 0), 65504.0F);
}

TEST(ImageFile, ColoursBeyondHalfKeepTheirHue) {
  const TemporaryFolder folder;
  Image image(4, 1, 3);
  const float colours[4][3] = {{131008, 65504, 32752}, {3e38F, 3e38F, 0}, {65504, 1, 2}, {0.5F, 1e6F, -1e9F}};
  for (int x = 0; x < 4; ++x)
    for (int c = 0; c < 3; ++c) image.at(c, x, 0) = colours[x][c];
  write_image(folder / "image.exr", image);
  const Image read = read_image(folder / "image.exr");
  const float expected[4][3] = {
      {65504, 32752, 16376}, {65504, 65504, 0}, {65504, 1, 2}, {0.032755F, 65504, 0}};
  for (int x = 0; x < 4; ++x)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(read.at(c, x, 0), expected[x][c], 1e-3F * expected[x][c]) << x << " " << c;
}

TEST(ImageFile, PngHoldsTheToneMapIn8Bits) {
  const TemporaryFolder folder;
  Image image = ramp(5, 3, 3);
  image.at(0, 4, 2) = std::numeric_limits<float>::infinity();
  write_image(folder / "image.png", image);
  const auto input = OIIO::ImageInput::open((folder / "image.png").string());
  ASSERT_TRUE(input);
  EXPECT_EQ(input->spec().width, 5);
  EXPECT_EQ(input->spec().height, 3);
  EXPECT_EQ(input->spec().nchannels, 3);
  EXPECT_EQ(input->spec().format, OIIO::TypeDesc::UINT8);
  std::vector<uint8_t> pixels(5 * 3 * 3);
  ASSERT_TRUE(input->read_image(0, 0, 0, 3, OIIO::TypeDesc::UINT8, pixels.data()));
  for (int y = 0; y < 3; ++y)
    for (int x = 0; x < 5; ++x)
      for (int c = 0; c < 3; ++c) {
        const double mapped = std::min(tone_map(static_cast<double>(image.at(c, x, y))), 1.0);
        EXPECT_EQ(pixels[static_cast<size_t>((y * 5 + x) * 3 + c)], std::lround(255 * mapped))
            << x << " " << y << " " << c;
      }
}

TEST(ImageFile, TheSameImageGivesTheSameBytes) {
  const TemporaryFolder folder;
  for (const char* extension : {".exr", ".png"})
    for (const int channels : {1, 3}) {
      write_image(folder / (std::string("a") + extension), ramp(9, 4, channels));
      write_image(folder / (std::string("b") + extension), ramp(9, 4, channels));
      const std::string bytes = read_file(folder / (std::string("a") + extension));
      EXPECT_GT(bytes.size(), 50u);
      EXPECT_EQ(bytes, read_file(folder / (std::string("b") + extension)));
    }
}

TEST(ImageFile, ThePictureIsLookedForByTheNamesOfParts) {
  const TemporaryFolder folder;
  const Imath::Box2i window({0, 0}, {2, 1});
  const auto part = [&](const std::string& name, float value) {
    return TestPart{
        name, window, {{"R", everywhere(value)}, {"G", everywhere(value)}, {"B", everywhere(value)}}};
  };
  const auto read = [&](const std::vector<TestPart>& parts) {
    write_exr_parts(folder / "parts.exr", window, parts);
    return read_image(folder / "parts.exr").pixels[0];
  };
  EXPECT_EQ(read({part("N", 1), part("albedo", 2), part("C", 3)}), 3.0F);                // Houdini
  EXPECT_EQ(read({part("ViewLayer.DiffCol", 1), part("ViewLayer.Combined", 2)}), 2.0F);  // Blender 5
  EXPECT_EQ(read({part("s000", 1), part("mean", 2)}), 2.0F);
  EXPECT_EQ(read({part("whatever", 4)}), 4.0F);
  EXPECT_EQ(read({TestPart{"depth", window, {{"Z", everywhere(1)}}}, part("some.pass", 5)}), 5.0F);
  EXPECT_ERROR(read({part("N", 1), part("albedo", 2)}),
               "several parts may be the picture ('N', 'albedo'); call that part 'beauty'");
  EXPECT_ERROR(read({part("beauty", 1), part("RGBA", 2)}), "several parts may be the picture");
  EXPECT_ERROR(read({part("s000", 1), part("s001", 2)}), "no part has the channels R, G and B");
}

TEST(ImageFile, Complaints) {
  const TemporaryFolder folder;
  EXPECT_ERROR(write_image(folder / "image.jpg", ramp(2, 2, 3)), "unknown extension '.jpg'");
  EXPECT_ERROR(write_image(folder / "image.exr", ramp(2, 2, 2)), "2 channels");
  EXPECT_ERROR(write_image(folder / "image.exr", Image()), "0 x 0");
  EXPECT_ERROR(read_image(folder / "image.exr"), "no such file");
  write_image(folder / "grey.exr", ramp(2, 2, 1));
  EXPECT_ERROR(read_image(folder / "grey.exr"), "no part has the channels R, G and B; found Y");
}

}  // namespace
}  // namespace ld
