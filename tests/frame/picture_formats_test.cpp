// What the module of other formats gives, and that its errors are those of the program.
#include "frame/picture_formats.h"

#include <OpenImageIO/imageio.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "core/file_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

constexpr int kMost = 16384;
constexpr int kWidth = 5, kHeight = 3, kChannels = 4;

/// A picture whose values survive 8 bits: 0, 1 / 255, ...
std::vector<float> ramp_pixels() {
  std::vector<float> pixels(kWidth * kHeight * kChannels);
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<float>(4 * i) / 255.0F;
  return pixels;
}

void write_pixels(const std::filesystem::path& path, OIIO::TypeDesc type) {
  const auto output = OIIO::ImageOutput::create(path.string());
  ASSERT_TRUE(output) << OIIO::geterror();
  ASSERT_TRUE(output->open(path.string(), OIIO::ImageSpec(kWidth, kHeight, kChannels, type)));
  ASSERT_TRUE(output->write_image(OIIO::TypeDesc::FLOAT, ramp_pixels().data()));
  ASSERT_TRUE(output->close());
}

TEST(PictureFormats, ReadsIntegersAndFloatsWithTheirAlpha) {
  const TemporaryFolder folder;
  const struct {
    const char* name;
    OIIO::TypeDesc type;
    bool small;
  } files[] = {{"a.png", OIIO::TypeDesc::UINT8, true},
               {"b.tif", OIIO::TypeDesc::UINT16, true},
               {"c.tif", OIIO::TypeDesc::FLOAT, false},
               {"d.exr", OIIO::TypeDesc::FLOAT, false}};
  for (const auto& file : files) {
    write_pixels(folder / file.name, file.type);
    const DecodedPicture picture = picture_formats().read(folder / file.name, kMost);
    EXPECT_EQ(picture.width, kWidth) << file.name;
    EXPECT_EQ(picture.height, kHeight) << file.name;
    EXPECT_EQ(picture.channels, kChannels) << file.name;
    EXPECT_EQ(picture.alpha, 3) << file.name;
    EXPECT_EQ(picture.small_integers, file.small) << file.name;
    const std::vector<float> expected = ramp_pixels();
    ASSERT_EQ(picture.pixels.size(), expected.size());
    // PNG multiplies colours with alpha, which rounds those of 8 bits once more.
    for (size_t i = 3; i < expected.size(); i += kChannels)
      EXPECT_NEAR(picture.pixels[i], expected[i], 1e-5F) << file.name << " " << i;
  }
}

TEST(PictureFormats, DecodesFilesInMemory) {
  const TemporaryFolder folder;
  write_pixels(folder / "a.png", OIIO::TypeDesc::UINT8);
  const std::string bytes = read_file(folder / "a.png");
  const DecodedPicture read = picture_formats().read(folder / "a.png", kMost);
  const DecodedPicture decoded = picture_formats().decode({bytes.begin(), bytes.end()}, "inside", kMost);
  EXPECT_EQ(decoded.pixels, read.pixels);
}

TEST(PictureFormats, ErrorsOfTheModuleAreThoseOfTheProgram) {
  const TemporaryFolder folder;
  EXPECT_ERROR(picture_formats().read(folder / "none.tif", kMost), "none.tif: cannot read it as a picture");
  EXPECT_ERROR(picture_formats().decode({1, 2, 3}, "inside", kMost),
               "inside: cannot read it as a PNG or JPEG");
  write_pixels(folder / "a.png", OIIO::TypeDesc::UINT8);
  EXPECT_ERROR(picture_formats().read(folder / "a.png", 4), "5 x 3 pixels with 4 channels; expected 1 to 4");
  try {
    picture_formats().read(folder / "none.tif", kMost);
  } catch (const std::exception& error) {
    const auto* ours = dynamic_cast<const Error*>(&error);
    ASSERT_NE(ours, nullptr);
    EXPECT_EQ(ours->exit_code(), 1);
  }
}

TEST(PictureFormats, DrawsTextWhereThereIsAFont) {
  const std::vector<float> letters = picture_formats().draw_text("Wide", 60, 18, 12, 4, 13);
  if (letters.empty()) GTEST_SKIP() << "no font on this machine";
  ASSERT_EQ(letters.size(), size_t{60 * 18});
  const auto [least, most] = std::minmax_element(letters.begin(), letters.end());
  EXPECT_EQ(*least, 0.0F);
  EXPECT_GT(*most, 0.8F);
  EXPECT_LE(*most, 1.0F);
}

}  // namespace
}  // namespace ld
