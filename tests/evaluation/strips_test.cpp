#include "evaluation/strips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>

#include "core/tone_map.h"
#include "evaluation/label.h"
#include "test_frames.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

Image filled(int width, int height, float value) {
  Image image(width, height, 3);
  std::fill(image.pixels.begin(), image.pixels.end(), value);
  return image;
}

TEST(Strips, PicturesStandSideBySideWithSeparators) {
  // Too narrow for labels, so the layout is the same with and without a font.
  const Image strip =
      make_strip({{"noisy", filled(5, 4, 1)}, {"a", filled(5, 4, 2)}, {"reference", filled(5, 4, 3)}});
  ASSERT_EQ(strip.width, 3 * 5 + 2 * 2);
  ASSERT_EQ(strip.height, 4);
  const float grey = strip.at(0, 5, 0);
  const std::vector<float> expected = {1, 1, 1, 1, 1, grey, grey, 2, 2, 2, 2, 2, grey, grey, 3, 3, 3, 3, 3};
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < strip.width; ++x)
        ASSERT_EQ(strip.at(c, x, y), expected[size_t(x)]) << x << " " << y;
}

TEST(Strips, LabelsStandAboveWithoutHidingThePicture) {
  const auto label = render_label("reference", 100);
  const int above = label ? kLabelHeight : 0;
  const Image strip = make_strip({{"reference", filled(100, 6, 7)}, {"", filled(100, 6, 8)}});
  ASSERT_EQ(strip.height, 6 + above);
  EXPECT_EQ(strip.at(0, 0, above), 7);
  EXPECT_EQ(strip.at(2, 201, above + 5), 8);
  if (label) {  // dark ground, and text that the tone map shows as white
    EXPECT_NEAR(tone_map(*std::max_element(label->pixels.begin(), label->pixels.end())), 1, 0.02);
    EXPECT_LT(tone_map(*std::min_element(label->pixels.begin(), label->pixels.end())), 0.2);
    const auto column_has_text = [&](int x) {
      for (int y = 0; y < kLabelHeight; ++y)
        if (strip.at(0, x, y) > 0.5F) return true;
      return false;
    };
    int columns_with_text = 0;
    for (int x = 0; x < 90; ++x) columns_with_text += column_has_text(x) ? 1 : 0;
    EXPECT_GT(columns_with_text, 20);
    EXPECT_FALSE(column_has_text(98)) << "nothing behind the end of a short word";
  }
  EXPECT_FALSE(render_label("reference", 10)) << "nothing readable fits";
}

TEST(Strips, BrokenPixelsAreMagenta) {
  Image image = filled(3, 3, 0.1F);
  image.at(1, 2, 0) = std::numeric_limits<float>::quiet_NaN();
  image.at(0, 0, 2) = std::numeric_limits<float>::infinity();
  const Image strip = make_strip({{"a", image}});
  for (const auto& [x, y] : {std::pair{2, 0}, {0, 2}}) {
    EXPECT_EQ(strip.at(0, x, y), 2);
    EXPECT_EQ(strip.at(1, x, y), 0);
    EXPECT_EQ(strip.at(2, x, y), 2);
  }
  EXPECT_EQ(strip.at(1, 1, 1), 0.1F);
}

TEST(Strips, UnequalSizesAndNothingAtAllAreErrors) {
  EXPECT_NE(message_of([] {
              make_strip({{"a", filled(3, 3, 0)}, {"b", filled(3, 4, 0)}});
            }).find("a is 3x3, b is 3x4"),
            std::string::npos);
  EXPECT_NE(message_of([] { make_strip({}); }), "");
  EXPECT_NE(message_of([] { stack_strips({}); }), "");
}

TEST(Strips, AStackFillsUpNarrowStrips) {
  const Image stack = stack_strips({filled(6, 2, 1), filled(4, 3, 2)});
  ASSERT_EQ(stack.width, 6);
  ASSERT_EQ(stack.height, 2 + 2 + 3);
  EXPECT_EQ(stack.at(0, 5, 1), 1);
  EXPECT_EQ(stack.at(0, 3, 4), 2);
  EXPECT_EQ(stack.at(0, 5, 4), stack.at(0, 0, 2)) << "the separators' grey";
}

TEST(Strips, TheWriterLeavesAStripForEachFrameAndAComparisonOfFour) {
  const TemporaryFolder folder;
  StripWriter writer(folder / "out", 10);
  for (size_t i = 0; i < 10; ++i)
    writer.add(i, "f" + std::to_string(i), {{"a", filled(8, 8, 0.5F)}, {"b", filled(8, 8, 1)}});
  const std::filesystem::path comparison = writer.finish();
  EXPECT_EQ(comparison, folder / "out" / "comparison.png");
  for (int i = 0; i < 10; ++i)
    EXPECT_TRUE(std::filesystem::exists(folder / "out" / "strips" / ("f" + std::to_string(i) + ".png")));
  // A PNG's header holds width and height as big-endian numbers at bytes 16 and 20.
  std::ifstream file(comparison, std::ios::binary);
  char header[24] = {};
  file.read(header, sizeof header);
  EXPECT_EQ(static_cast<unsigned char>(header[19]), 8 + 2 + 8);
  EXPECT_EQ(static_cast<unsigned char>(header[23]), 4 * 8 + 3 * 2);
}

}  // namespace
}  // namespace ld
