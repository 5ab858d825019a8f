// Frame sets from files: written by the project's own writer, read back for the evaluator.
#include "evaluation/data_set.h"

#include <gtest/gtest.h>

#include <filesystem>

#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "test_frames.h"
#include "tests/support/exr_parts.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

class DataSetOnDisk : public testing::Test {
 protected:
  void SetUp() override {
    Manifest manifest;
    for (int i = 0; i < 3; ++i) {
      const EvaluationFrame frame = noisy_frame("frame_" + std::to_string(i), 12, 9, 2, i);
      write_frame(frame_path(folder_.path(), frame.name), frame.frame);
      write_image(reference_path(folder_.path(), frame.name), frame.reference, {}, {{"psnr", 40.0 + i}});
      ManifestFrame entry;
      entry.name = frame.name;
      entry.split = i == 2 ? "train" : "test";
      entry.index = i;
      manifest.frames.push_back(entry);
    }
    add_to_manifest(folder_.path(), manifest);
  }

  TemporaryFolder folder_;
};

TEST_F(DataSetOnDisk, LoadsTheFramesOfTheSplitInOrder) {
  const FrameSet frames = open_frame_set(folder_.path(), "test", {"radiance"}, 0);
  ASSERT_EQ(frames.count, 2U);
  for (size_t i = 0; i < 2; ++i) {
    const EvaluationFrame expected = noisy_frame("frame_" + std::to_string(i), 12, 9, 2, static_cast<int>(i));
    const EvaluationFrame loaded = frames.load(i);
    EXPECT_EQ(loaded.name, expected.name);
    EXPECT_EQ(loaded.frame.spp, 2);
    EXPECT_EQ(loaded.floor, (ReferenceFloor{{"psnr", 40.0 + static_cast<double>(i)}}));
    ASSERT_EQ(loaded.reference.pixels.size(), expected.reference.pixels.size());
    for (size_t p = 0; p < expected.reference.pixels.size(); ++p)
      ASSERT_NEAR(loaded.reference.pixels[p] / expected.reference.pixels[p], 1,
                  1e-3);  // half floats in the file
    ASSERT_NEAR(loaded.frame.plane(1, 2)[50] / expected.frame.plane(1, 2)[50], 1, 1e-3);
  }
  EXPECT_EQ(open_frame_set(folder_.path(), "test", {"radiance"}, 1).count, 1U);
  EXPECT_EQ(open_frame_set(folder_.path(), "train", {"radiance"}, 9).count, 1U);
}

TEST_F(DataSetOnDisk, FramesOfASequenceComeInItsOrder) {
  Manifest manifest;
  const std::vector<std::pair<int, int>> places = {{5, 1}, {5, 0}, {5, 3}, {4, 0}, {5, 0}};
  for (size_t i = 0; i < places.size(); ++i) {
    const EvaluationFrame frame = noisy_frame("s" + std::to_string(i), 6, 5, 1, static_cast<int>(i));
    write_frame(frame_path(folder_ / "s", frame.name), frame.frame);
    write_image(reference_path(folder_ / "s", frame.name), frame.reference);
    ManifestFrame entry;
    entry.name = frame.name;
    entry.split = "test";
    entry.sequence = places[i].first;
    entry.position = places[i].second;
    manifest.frames.push_back(entry);
  }
  add_to_manifest(folder_ / "s", manifest);
  const auto walk = [&](size_t limit) {
    const FrameSet frames = open_frame_set(folder_ / "s", "test", {"radiance"}, limit);
    SequenceState state;
    std::string text;
    for (size_t i = 0; i < frames.count; ++i) {
      const EvaluationFrame frame = frames.load(i);
      EXPECT_EQ(frame.name, frames.names[i]);
      state.advance(frame.in_sequence, frame.frame.width, frame.frame.height);
      text += fmt::format("{} {}, ", frame.name, state.history());
    }
    return text;
  };
  EXPECT_EQ(walk(0), "s1 0, s0 1, s2 0, s3 0, s4 0, ") << "s4 is another noise instance of s1";
  EXPECT_EQ(walk(2), "s1 0, s0 1, ");
  EXPECT_EQ(walk(1), "s0 0, ");
}

TEST_F(DataSetOnDisk, ReadsTheFirstSamplesOnRequest) {
  const EvaluationFrame all = open_frame_set(folder_.path(), "test", {"radiance"}, 0).load(1),
                        one = open_frame_set(folder_.path(), "test", {"radiance"}, 0, 1).load(1);
  EXPECT_EQ(one.frame.spp, 1);
  const size_t kept = one.frame.plane_size();
  ASSERT_EQ(one.frame.samples.size(), kept * kSampleChannels);
  EXPECT_TRUE(std::equal(one.frame.samples.begin(), one.frame.samples.end(), all.frame.samples.begin()));
  const Image noisy = mean_radiance(one.frame);
  EXPECT_TRUE(std::equal(noisy.pixels.begin(), noisy.pixels.end(), all.frame.plane(0, 0)))
      << "the mean is that of the samples that were read";
  const FrameSet three = open_frame_set(folder_.path(), "test", {"radiance"}, 0, 3);
  const std::string message = message_of([&] { three.load(1); });
  EXPECT_NE(message.find("frame_1.exr: 2 samples a pixel, but 3 are asked for"), std::string::npos)
      << message;
}

TEST_F(DataSetOnDisk, EvaluatesFromTheFiles) {
  const auto result = evaluate(open_frame_set(folder_.path(), "test", {"radiance"}, 0), {}, {});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->method("noisy").frames.size(), 2U);
  EXPECT_LT(result->method("blur").mean(0), result->method("noisy").mean(0));
}

TEST_F(DataSetOnDisk, AReferenceOfAnotherSizeNamesBothFilesAndSizes) {
  write_image(reference_path(folder_.path(), "frame_1"), Image(11, 9, 3));
  const FrameSet frames = open_frame_set(folder_.path(), "test", {"radiance"}, 0);
  const std::string message = message_of([&] { frames.load(1); });
  for (const char* part :
       {"frame_1.exr 12 x 9 pixels", "frame_1.reference.exr is 11 x 9 pixels", "of another display window"})
    EXPECT_NE(message.find(part), std::string::npos) << message;
}

// As when somebody takes a frame of many samples for the reference.
TEST_F(DataSetOnDisk, AReferenceThatHoldsSamplesIsReadByItsPicture) {
  const Imath::Box2i picture({0, 0}, {11, 8}), samples({3, 3}, {6, 6});
  const auto part = [](const std::string& name, const Imath::Box2i& window, float value) {
    return TestPart{
        name, window, {{"R", everywhere(value)}, {"G", everywhere(value)}, {"B", everywhere(value)}}};
  };
  write_exr_parts(reference_path(folder_.path(), "frame_1"), picture,
                  {part("mean", picture, 0.5F), part("s000", samples, 7)});
  const EvaluationFrame frame = open_frame_set(folder_.path(), "test", {"radiance"}, 0).load(1);
  EXPECT_EQ(frame.reference.width, 12);
  EXPECT_EQ(frame.reference.at(1, 11, 8), 0.5F);
}

TEST_F(DataSetOnDisk, MissingThingsAreNamed) {
  EXPECT_NE(message_of([&] { open_frame_set(folder_ / "nowhere", "test", {"radiance"}, 0); }).find("nowhere"),
            std::string::npos);
  const std::string no_split =
      message_of([&] { open_frame_set(folder_.path(), "validation", {"radiance"}, 0); });
  EXPECT_NE(no_split.find("validation"), std::string::npos) << no_split;
  std::filesystem::remove(reference_path(folder_.path(), "frame_0"));
  const FrameSet frames = open_frame_set(folder_.path(), "test", {"radiance"}, 0);
  EXPECT_NE(message_of([&] { frames.load(0); }).find("frame_0.reference.exr"), std::string::npos);
}

}  // namespace
}  // namespace ld
