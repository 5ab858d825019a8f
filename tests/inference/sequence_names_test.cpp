#include "inference/sequence_names.h"

#include <gtest/gtest.h>

#include "core/file_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

class FrameSequence : public ::testing::Test {
 protected:
  void SetUp() override {
    for (const char* name :
         {"a.0007.exr", "a.0008.exr", "a.0010.exr", "a.12345.exr", "a.00008.exr", "a.x.exr", "b.0008.exr"})
      write_file_atomically(folder_ / name, "");
  }
  std::string in(const std::string& name) const { return (folder_ / name).string(); }
  std::vector<DenoiseTask> plan(const std::vector<std::string>& inputs, const std::string& output,
                                std::optional<FrameRange> range = {}, bool samples_of_one = false) const {
    std::vector<std::string> paths;
    for (const std::string& input : inputs) paths.push_back(in(input));
    return plan_tasks(paths, in(output), range, samples_of_one);
  }

  TemporaryFolder folder_;
};

TEST_F(FrameSequence, FindsTheFramesThatThereAre) {
  const auto tasks = plan({"a.####.exr"}, "out.##.exr");
  ASSERT_EQ(tasks.size(), 4u);
  EXPECT_EQ(tasks[0].inputs[0], in("a.0007.exr"));
  EXPECT_EQ(tasks[0].output, in("out.07.exr"));
  EXPECT_EQ(tasks[2].output, in("out.10.exr"));
  EXPECT_EQ(tasks[3].inputs[0], in("a.12345.exr"));
  EXPECT_EQ(tasks[3].output, in("out.12345.exr"));
  EXPECT_ERROR(plan({"none.####.exr"}, "out"), "none.####.exr");
}

TEST_F(FrameSequence, ARangeNamesFramesWhetherTheyAreThereOrNot) {
  const auto tasks = plan({"a.####.exr"}, "folder", parse_frame_range("8:11"));
  ASSERT_EQ(tasks.size(), 3u);
  EXPECT_EQ(tasks[1].inputs[0], in("a.0009.exr"));
  EXPECT_EQ(tasks[1].output, in("folder/a.0009.exr"));
  for (const char* wrong : {"", "8", "8:", "8:8", "9:8", "a:b", "1:2:3", "1:99999999999"})
    EXPECT_ERROR(parse_frame_range(wrong), "A:B");
}

TEST_F(FrameSequence, NumbersMayBeNegativeAndTheSignMayTakeADigitsPlace) {
  for (const char* name : {"n.-0002.exr", "n.-001.exr", "n.0000.exr", "n.0001.exr"})
    write_file_atomically(folder_ / name, "");
  const auto all = plan({"n.####.exr"}, "out.####.exr");
  ASSERT_EQ(all.size(), 4u);
  EXPECT_EQ(all[0].inputs[0], in("n.-0002.exr"));
  EXPECT_EQ(all[0].output, in("out.-0002.exr"));
  EXPECT_EQ(all[1].inputs[0], in("n.-001.exr"));
  EXPECT_EQ(all[2].inputs[0], in("n.0000.exr"));
  const auto some = plan({"n.####.exr"}, "out", parse_frame_range("-1:1"));
  ASSERT_EQ(some.size(), 2u);
  EXPECT_EQ(some[0].inputs[0], in("n.-001.exr"));
}

TEST_F(FrameSequence, SeveralInputsAreSeveralPicturesOrTheSamplesOfOne) {
  const auto pictures = plan({"a.0007.exr", "a.0008.exr"}, "out");
  ASSERT_EQ(pictures.size(), 2u);
  EXPECT_EQ(pictures[1].output, in("out/a.0008.exr"));
  EXPECT_ERROR(plan({"a.0007.exr", "a.0008.exr"}, "out.exr"), "2 pictures for one output");
  const auto one = plan({"a.0007.exr", "a.0008.exr"}, "out.exr", {}, true);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].inputs.size(), 2u);
  EXPECT_EQ(one[0].output, in("out.exr"));
  const auto numbered = plan({"a.####.exr", "b.####.exr"}, "out.####.exr", FrameRange{8, 9}, true);
  ASSERT_EQ(numbered.size(), 1u);
  EXPECT_EQ(numbered[0].inputs[1], in("b.0008.exr"));
  const auto file = plan({"a.0007.exr"}, "out.png");
  EXPECT_EQ(file[0].output, in("out.png"));
  EXPECT_EQ(plan({"a.0007.exr"}, "new/")[0].output, in("new/a.0007.exr"));
}

TEST_F(FrameSequence, SequenceAfterSequenceWithThePlacesOfTheirFrames) {
  const auto places = [](const std::vector<DenoiseTask>& tasks) {
    std::string text;
    for (const DenoiseTask& task : tasks)
      text += fmt::format(
          "{} {}, ", task.inputs[0].filename().string(),
          task.place ? fmt::format("{}/{}", task.place->sequence, task.place->position) : "still");
    return text;
  };
  const FrameRange range = {7, 9};
  EXPECT_EQ(places(plan({"a.####.exr", "b.####.exr"}, "out", range)),
            "a.0007.exr 0/7, a.0008.exr 0/8, b.0007.exr 1/7, b.0008.exr 1/8, ");
  EXPECT_EQ(places(plan({"a.####.exr", "b.####.exr"}, "out", range, true)),
            "a.0007.exr 0/7, a.0008.exr 0/8, ");
  EXPECT_EQ(places(plan({"a.0007.exr", "a.0008.exr"}, "out")), "a.0007.exr still, a.0008.exr still, ");
}

TEST_F(FrameSequence, RefusesWhatWouldOverwriteOrCannotBeToldApart) {
  EXPECT_ERROR(plan({"a.0007.exr"}, "a.0007.exr"), "one of the inputs");
  EXPECT_ERROR(plan({"a.0007.exr", "./a.0007.exr"}, "out"), "two pictures");
  EXPECT_ERROR(plan({"a.0007.exr", "a.####.exr"}, "out"), "one kind");
  EXPECT_ERROR(plan({"a.0007.exr"}, "out.exr", FrameRange{1, 2}), "####");
  EXPECT_ERROR(plan({"a.0007.exr"}, "out.####.exr"), "numbered");
  EXPECT_ERROR(plan({"a.##.##.exr"}, "out"), "two places");
}

}  // namespace
}  // namespace ld
