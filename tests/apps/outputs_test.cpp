// Outputs that cannot be are refused before the work, and so are two frames in one place of a sequence.
#include <gtest/gtest.h>

#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "tests/support/exr_parts.h"
#include "tests/support/run_program.h"

namespace ld {
namespace {

namespace fs = std::filesystem;
const Imath::Box2i kWindow({0, 0}, {7, 5});

class Outputs : public ::testing::Test {
 protected:
  std::string path(const std::string& name) const { return (folder_ / name).string(); }

  std::string render(const std::string& name, float value) const {
    TestPart part{"", kWindow, {}};
    for (const char* colour : {"R", "G", "B"})
      part.channels.emplace_back(colour, [value](int x, int y) { return value + float(x * y) / 8; });
    write_exr_parts(path(name), kWindow, {part});
    return path(name);
  }

  /// Refused before the model, which is not there, is missed; nothing is made.
  void expect_export_refused(const std::vector<std::string>& more, const std::vector<std::string>& texts) {
    std::vector<std::string> arguments = {"--model", path("none.safetensors")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    expect_failure(run_program("ld_export", arguments), 2, texts);
    EXPECT_TRUE(fs::is_empty(path("outputs")));
  }
  void expect_import_refused(const std::string& frame, const std::vector<std::string>& texts) {
    expect_failure(run_program("ld_import", {"--preset", "mitsuba", "--frame", frame, path("none.exr")}), 2,
                   texts);
    EXPECT_TRUE(fs::is_empty(path("outputs")));
  }
  ProgramResult add(const std::string& name, const std::vector<std::string>& more,
                    const std::string& split = "train") const {
    std::vector<std::string> arguments = {
        "--preset", "mitsuba", "--out",       path("set"),           "--name",          name,
        "--split",  split,     "--reference", path("reference.exr"), path("sample.exr")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_program("ld_import", arguments);
  }

  void SetUp() override { fs::create_directory(path("outputs")); }
  TemporaryFolder folder_;
};

TEST_F(Outputs, FilesAreCalledLikeWhatTheyHold) {
  const std::string good = path("outputs/m.safetensors");
  for (const char* name : {"outputs/m.onnx", "outputs/m.exr", "outputs/m", "outputs/.safetensors"})
    expect_export_refused({"--format", "safetensors", "--out", path(name)},
                          {"--out", path(name), ".safetensors"});
  expect_export_refused({"--format", "onnx", "--out", good}, {"--out", good, ".onnx"});
  expect_export_refused({"--format", "safetensors", "--out", good, "--card", path("outputs/card.txt")},
                        {"--card", "card.txt", ".md"});
  expect_export_refused({"--format", "safetensors", "--out", good, "--check-data", path("outputs/data.npz")},
                        {"--check-data", "data.npz", ".safetensors"});
  expect_failure(run_program("ld_import", {"--out", path("none"), "--split", "train", "--to-hdf5",
                                           path("outputs/s.exr"), "--reference", path("outputs/r.h5")}),
                 2, {"--to-hdf5", "s.exr", ".h5"});
  expect_failure(run_program("ld_import", {"--out", path("none"), "--split", "train", "--to-hdf5",
                                           path("outputs/s.h5"), "--reference", path("outputs/r.exr")}),
                 2, {"--reference", "r.exr", ".h5"});
  for (const char* name : {"outputs/f.png", "outputs/f", "outputs/f.exr.bak"})
    expect_import_refused(path(name), {"--frame", path(name), ".exr"});
}

TEST_F(Outputs, FoldersThatCannotBeWrittenInto) {
  render("file", 1);
  fs::create_directory(path("outputs/folder.exr"));
  for (const std::string& folder : {path("file"), path("file/below"), std::string("/proc/none")}) {
    const std::vector<std::string> texts = {"cannot write", folder.substr(0, folder.find("/below"))};
    expect_failure(
        run_program("ld_export", {"--model", path("none"), "--format", "onnx", "--out", folder + "/m.onnx"}),
        2, texts);
    expect_failure(
        run_program("ld_import", {"--preset", "mitsuba", "--frame", folder + "/f.exr", path("none.exr")}), 2,
        texts);
    expect_failure(run_program("ld_import", {"--preset", "mitsuba", "--out", folder, "--name", "a", "--split",
                                             "train", "--reference", path("none.exr"), path("none.exr")}),
                   2, texts);
    expect_failure(run_program("ld_denoise", {path("none.exr"), "--output", folder + "/f.exr"}), 2, texts);
    expect_failure(run_program("ld_denoise",
                               {path("none.exr"), "--output", path("o.exr"), "--noisy", folder + "/f.exr"}),
                   2, texts);
  }
  expect_failure(run_program("ld_import", {"--preset", "mitsuba", "--frame", path("outputs/folder.exr"),
                                           path("none.exr")}),
                 2, {"folder.exr", "is a folder"});
  fs::remove(path("outputs/folder.exr"));
  EXPECT_TRUE(fs::is_empty(path("outputs"))) << "nothing is left of the trial";
  // Folders that are missing are made, as by the other programs.
  const ProgramResult made = run_program(
      "ld_import", {"--preset", "mitsuba", "--frame", path("outputs/new/deep/F.EXR"), path("file")});
  EXPECT_EQ(made.exit_code, 0) << made.output;
  EXPECT_TRUE(fs::exists(path("outputs/new/deep/F.EXR")));
}

TEST_F(Outputs, OneFrameForEachPlaceOfASequence) {
  render("reference.exr", 1);
  render("sample.exr", 2);
  ASSERT_EQ(add("first", {"--sequence", "3", "--position", "0"}).exit_code, 0);
  ASSERT_EQ(add("second", {"--sequence", "3", "--position", "1"}).exit_code, 0);
  fs::remove(path("sample.exr"));  // before it is read
  for (const char* split : {"train", "test"})
    expect_failure(add("third", {"--sequence", "3", "--position", "1"}, split), 2,
                   {"second", "third", "sequence 3", "position 1"});
  expect_failure(add("third", {"--sequence", "3"}), 2, {"--sequence", "--position"});
  expect_failure(add("third", {"--position", "3"}), 2, {"--sequence", "--position"});
  expect_failure(add("third", {"--sequence=-3", "--position", "1"}), 2, {"--sequence"});
  expect_failure(add("third", {"--sequence", "3", "--position=-1"}), 2, {"--position"});
  expect_failure(run_program("ld_import", {"--preset", "mitsuba", "--frame", path("f.exr"), "--sequence", "1",
                                           "--position", "1", path("sample.exr")}),
                 2, {"--sequence", "--frame"});
  EXPECT_FALSE(fs::exists(path("set/third.exr")));
  render("sample.exr", 3);
  EXPECT_EQ(add("second", {"--sequence", "3", "--position", "1"}).exit_code, 0)
      << "a frame takes its own place";
  EXPECT_EQ(add("third", {"--sequence", "4", "--position", "1"}).exit_code, 0);
  EXPECT_EQ(add("fourth", {}).exit_code, 0);
  EXPECT_EQ(add("fifth", {}).exit_code, 0) << "frames of no sequence have no place";
  EXPECT_EQ(read_manifest(path("set")).frames.size(), 5u);
}

}  // namespace
}  // namespace ld
