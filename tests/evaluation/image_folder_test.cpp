// Pictures that another program left on disk, as a method.
#include "evaluation/image_folder.h"

#include <gtest/gtest.h>

#include "core/file_io.h"
#include "evaluation/evaluator.h"
#include "frame/frame_file.h"
#include "test_frames.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

const std::vector<std::string> kFrames = {"a", "b"};

class ImageFolder : public testing::Test {
 protected:
  void SetUp() override {
    for (int i = 0; i < 2; ++i)
      write_image(folder_ / (kFrames[size_t(i)] + ".exr"), smooth_picture(12, 9, i));
  }
  static PicturePlace at(int width, int height, const Windows& windows = {}) {
    PicturePlace place;
    place.extent = {width, height, windows};
    return place;
  }
  Method method() const { return image_folder_method("other", folder_.path(), kFrames); }

  TemporaryFolder folder_;
};

TEST_F(ImageFolder, GivesThePictureOfEachFrame) {
  for (int i = 0; i < 2; ++i) {
    const Image expected = smooth_picture(12, 9, i), read = method().read(kFrames[size_t(i)], at(12, 9));
    ASSERT_EQ(read.pixels.size(), expected.pixels.size());
    for (size_t p = 0; p < expected.pixels.size(); ++p)
      ASSERT_NEAR(read.pixels[p], expected.pixels[p], 1e-3);  // half floats
  }
}

TEST_F(ImageFolder, IsEvaluatedLikeAModelWithTheTimesThatItNoted) {
  const FrameSet frames = {2, [](size_t i) { return noisy_frame(kFrames[i], 12, 9, 2, int(i)); }, kFrames};
  const auto untimed = evaluate(frames, {method()}, {});
  EXPECT_FALSE(untimed->method("other").mean_seconds());
  EXPECT_GT(untimed->method("other").mean(3), untimed->method("blur").mean(3));  // the reference itself

  write_file_atomically(folder_ / "cost.json", R"({"threads": 2, "seconds": {"a": 0.5, "b": 1.5}})");
  EXPECT_EQ(evaluate(frames, {method()}, {})->method("other").mean_seconds(), 1.0);
  write_file_atomically(folder_ / "cost.json", R"({"seconds": {"a": 0.5}})");
  EXPECT_FALSE(evaluate(frames, {method()}, {})->method("other").mean_seconds()) << "of one frame only";
  write_file_atomically(folder_ / "cost.json", R"({"seconds": 3})");
  EXPECT_ERROR(method(), "cost.json: expected");
}

TEST_F(ImageFolder, KeepsNegativeValues) {
  Image negative(12, 9, 3);
  negative.at(1, 3, 4) = -0.5F;
  write_image(folder_ / "a.exr", negative);
  EXPECT_EQ(method().read("a", at(12, 9)).at(1, 3, 4), -0.5F);
}

TEST_F(ImageFolder, MissingPicturesAreNamedAndCountedBeforeAnythingRuns) {
  std::filesystem::remove(folder_ / "b.exr");
  EXPECT_ERROR(method(), "b.exr is missing (1 of 2 frames have no picture); expected one OpenEXR file");
  write_image(folder_ / "b.png", smooth_picture(12, 9, 1));
  EXPECT_ERROR(method(), "b.png is there, but the metrics need linear radiance");
  EXPECT_ERROR(image_folder_method("other", folder_ / "nowhere", kFrames), "no such folder");
}

TEST_F(ImageFolder, PicturesAreComparedWhereTheyLie) {
  // The frame is pixels (4, 3) to (8, 6) of a display window of 12 x 9.
  const Windows crop{4, 3, 0, 0, 11, 8};
  const Image whole = smooth_picture(12, 9, 0), part = method().read("a", at(5, 4, crop));
  ASSERT_EQ(part.width, 5);
  for (int c = 0; c < 3; ++c)
    for (int y = 0; y < 4; ++y)
      for (int x = 0; x < 5; ++x) ASSERT_NEAR(part.at(c, x, y), whole.at(c, x + 4, y + 3), 1e-3);
  write_image(folder_ / "a.exr", part, crop);
  EXPECT_EQ(method().read("a", at(5, 4, crop)).pixels, part.pixels);
  EXPECT_ERROR(method().read("a", at(5, 4, {3, 3, 0, 0, 11, 8})),
               "5 x 4 pixels at (4, 3), its frame 'a' 5 x 4 pixels at (3, 3)");
  EXPECT_ERROR(method().read("a", at(6, 4, crop)), "write it with the frame's data window");
}

TEST_F(ImageFolder, OtherSizesAndDamageNameTheFile) {
  EXPECT_ERROR(method().read("a", at(24, 18)),
               "a.exr is 12 x 9 pixels at (0, 0), its frame 'a' 24 x 18 pixels at (0, 0)");
  EXPECT_ERROR(method().read("a", at(6, 5)), "of another display window");
  write_file_atomically(folder_ / "a.exr", "no picture");
  EXPECT_ERROR(method().read("a", at(12, 9)), "a.exr");
  write_image(folder_ / "a.exr", Image(12, 9, 1));
  EXPECT_ERROR(method().read("a", at(12, 9)), "no part has the channels R, G and B; found Y");
}

}  // namespace
}  // namespace ld
