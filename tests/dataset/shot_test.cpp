#include "dataset/shot.h"

#include <gtest/gtest.h>

#include "core/file_io.h"
#include "dataset/frame_store.h"
#include "metrics/smape.h"
#include "tests/support/expect_error.h"
#include "tests/support/packed_crop.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

std::string splits_of(const std::vector<ManifestFrame>& frames) {
  std::string splits;
  for (const ManifestFrame& frame : frames) splits += frame.split[0];
  return splits;
}

/// Frames without references and without a manifest.
void write_frames(const fs::path& folder, int count, int spp = 4) {
  fs::create_directories(folder);
  for (int i = 0; i < count; ++i)
    write_frame(frame_path(folder, "shot_" + std::to_string(10 + i)),
                random_frame(20, 18, spp, static_cast<uint32_t>(i)));
}

TEST(Shot, FilesOfAFolderAreItsFramesAndOneOfEveryFewIsHeldOut) {
  const TemporaryFolder folder;
  write_frames(folder.path(), 7);
  write_image(reference_path(folder.path(), "shot_10"), Image(20, 18, 3));
  const std::vector<ManifestFrame> frames = frames_of_shot(folder.path(), 3);
  EXPECT_EQ(splits_of(frames), "tvttvtt");
  EXPECT_EQ(frames.front().name, "shot_10");
  EXPECT_EQ(frames.back().name, "shot_16");
  for (const ManifestFrame& frame : frames) EXPECT_FALSE(frame.has_reference);
  EXPECT_EQ(splits_of(frames_of_shot(folder.path(), 100)), "tttvttt");
  EXPECT_EQ(of_split(frames, "validation").size(), 2U);
  const std::string state = shot_state(folder.path());
  EXPECT_EQ(state, shot_state(folder.path()));
  write_frames(folder.path(), 8);
  EXPECT_NE(state, shot_state(folder.path()));
}

TEST(Shot, AManifestSaysWhatIsHeldOutAndItsTestFramesAreLeftAlone) {
  const TemporaryFolder folder;
  write_tiny_dataset(folder.path(), 4);
  const std::vector<ManifestFrame> frames = frames_of_shot(folder.path(), 3);
  EXPECT_EQ(splits_of(frames), "ttttv");
  EXPECT_FALSE(frames.front().has_reference);
}

TEST(Shot, OneFrameIsTooFewAndAMissingFolderIsNamed) {
  const TemporaryFolder folder;
  write_frames(folder.path(), 1);
  EXPECT_ERROR(frames_of_shot(folder.path(), 5), "1 frames to learn from");
  EXPECT_ERROR(frames_of_shot(folder.path(), 5), "at least two");
  EXPECT_ERROR(frames_of_shot(folder.path() / "nowhere", 5), "nowhere");
  EXPECT_ERROR(frames_of_shot(folder.path() / "nowhere", 5), "no such folder");
}

TEST(Shot, AStoreReadsItsFramesWithoutReferencesFromTheCacheToo) {
  const TemporaryFolder folder;
  write_frames(folder.path(), 2);
  const std::vector<ManifestFrame> frames = of_split(frames_of_shot(folder.path(), 2), "train");
  ASSERT_EQ(frames.size(), 1U);
  for (int pass = 0; pass < 2; ++pass) {
    FrameStore store(folder.path(), frames, {"radiance", "normal"}, {});
    const auto packed = store.get(0);
    EXPECT_EQ(packed->spp, 4);
    EXPECT_TRUE(packed->intact({0, 0, 2, 2}));
  }
}

/// The mean radiance of some of a frame's samples.
Image mean_of(const Frame& frame, const SampleList& samples) {
  Image mean(frame.width, frame.height, 3);
  for (size_t p = 0; p < frame.plane_size(); ++p) {
    int drawn = 0;
    for (const int s : samples) drawn += frame.valid_plane(s)[p];
    for (int c = 0; c < 3; ++c) {
      float sum = 0;
      for (const int s : samples)
        if (frame.valid_plane(s)[p] != 0) sum += frame.plane(s, kRadianceOffset + c)[p];
      mean.plane(c)[p] = drawn > 0 ? sum / static_cast<float>(drawn) : 0;
    }
  }
  return mean;
}

TEST(SampleTargets, TakeThePlaceOfTheReferenceTurnedAsItIs) {
  const Frame frame = random_frame(37, 21, 5, 3);
  const SampleList targets = {1, 4};
  const PackedFrame plain = pack(frame, Image(), frame.features);
  const PackedFrame expected = pack(frame, mean_of(frame, targets), frame.features);
  Augmentation part = whole_frame(37, 21, true, false, 1);
  part.exposure = {2, 2, 2};
  part.colours = {2, 0, 1};
  const size_t pixels = 37 * 21;
  std::vector<float> features(2 * pixels * static_cast<size_t>(plain.channels())), radiance(2 * 3 * pixels),
      valid(2 * pixels), target(3 * pixels);
  read_crop(plain, part, plain.features, {features.data(), radiance.data(), valid.data(), target.data()},
            {0, 2}, targets);
  const CropOfFrame reference = crop_of(expected, part);
  for (size_t i = 0; i < target.size(); ++i)
    ASSERT_NEAR(target[i], reference.reference.pixels[i], 2e-3 * (1 + reference.reference.pixels[i])) << i;
}

TEST(SampleTargets, APixelWithoutAnyKeepsTheMeanOfAllSamples) {
  Frame frame = random_frame(16, 16, 3, 4);
  std::fill(frame.valid.begin(), frame.valid.end(), uint8_t{1});
  const size_t pixel = 5 * 16 + 7;
  frame.valid_plane(1)[pixel] = 0;
  const PackedFrame packed = pack(frame, Image(), frame.features);
  std::vector<float> features(256 * static_cast<size_t>(packed.channels())), radiance(3 * 256), valid(256),
      target(3 * 256);
  read_crop(packed, whole_frame(16, 16), packed.features,
            {features.data(), radiance.data(), valid.data(), target.data()}, {0}, {1});
  const Image all = mean_of(frame, {0, 1, 2}), own = mean_of(frame, {1});
  EXPECT_EQ(target[pixel], all.plane(0)[pixel]);
  EXPECT_NEAR(target[pixel + 1], own.plane(0)[pixel + 1], 1e-3 * own.plane(0)[pixel + 1]);
}

TEST(SampleTargets, WithoutAReferenceATileIsAsDifficultAsItsHalvesDiffer) {
  Frame frame = random_frame(16, 16, 4, 5);
  std::fill(frame.valid.begin(), frame.valid.end(), uint8_t{1});
  const PackedFrame packed = pack(frame, Image(), frame.features);
  EXPECT_NEAR(packed.difficulty[0], smape(mean_of(frame, {0, 2}), mean_of(frame, {1, 3})), 1e-5);
}

}  // namespace
}  // namespace ld
