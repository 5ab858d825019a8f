#include "frame/manifest.h"

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <thread>

#include "core/checksum.h"
#include "core/file_io.h"
#include "core/random.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

Manifest one_frame(int64_t index, const std::string& split = "train") {
  Manifest manifest;
  manifest.recipe = "width: 8\n";
  manifest.seed = 0xfedcba9876543210ULL;
  manifest.frames.push_back({fmt::format("frame_{:06}", index), split, index, "0123456789abcdef", ""});
  return manifest;
}

TEST(Manifest, RoundTripOrderedByNameAndReplaced) {
  const TemporaryFolder folder;
  add_to_manifest(folder.path(), one_frame(12));
  add_to_manifest(folder.path(), one_frame(3, "validation"));
  Manifest again = one_frame(12);
  again.frames[0].reference_checksum = "fedcba9876543210";
  again.frames[0].sequence = 4;
  again.frames[0].position = 0;
  add_to_manifest(folder.path(), again);
  const Manifest read = read_manifest(folder.path());
  EXPECT_EQ(read.recipe, "width: 8\n");
  EXPECT_EQ(read.seed, 0xfedcba9876543210ULL);
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.frames[0].name, "frame_000003");
  EXPECT_EQ(read.frames[0].split, "validation");
  EXPECT_EQ(read.frames[0].index, 3);
  EXPECT_EQ(read.frames[0].checksum, "0123456789abcdef");
  EXPECT_EQ(read.frames[0].reference_checksum, "");
  EXPECT_EQ(read.frames[1].reference_checksum, "fedcba9876543210");
  EXPECT_FALSE(read.frames[0].sequence);
  EXPECT_EQ(read.frames[1].sequence, 4);
  EXPECT_EQ(read.frames[1].position, 0);
  // The order of additions leaves no trace.
  const TemporaryFolder other;
  add_to_manifest(other.path(), one_frame(3, "validation"));
  add_to_manifest(other.path(), again);
  EXPECT_EQ(read_file(folder / "manifest.json"), read_file(other / "manifest.json"));
}

TEST(Manifest, WrittenByHand) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "manifest.json", R"({"format": "ld-dataset", "version": 1, "frames": [
    {"name": "shot/b", "split": "test"}, {"name": "a", "split": "train"}]})");
  const Manifest read = read_manifest(folder.path());
  ASSERT_EQ(read.frames.size(), 2u);
  EXPECT_EQ(read.frames[0].name, "a");
  EXPECT_EQ(read.frames[1].name, "shot/b");
  EXPECT_EQ(frame_path("data", "shot/b"), "data/shot/b.exr");
  EXPECT_EQ(reference_path("data", "shot/b"), "data/shot/b.reference.exr");
}

TEST(Manifest, EveryMistakeIsNamed) {
  const TemporaryFolder folder;
  EXPECT_ERROR(read_manifest(folder / "none"), "no such folder");
  EXPECT_ERROR(read_manifest(folder.path()), "no manifest.json");
  const auto read = [&](const std::string& text) {
    write_file_atomically(folder / "manifest.json", text);
    return read_manifest(folder.path());
  };
  const auto read_frames = [&](const std::string& frames) {
    return read(R"({"format": "ld-dataset", "version": 1, "frames": )" + frames + "}");
  };
  EXPECT_ERROR(read(""), "not valid JSON");
  EXPECT_ERROR(read("{\"format\": "), "not valid JSON");
  EXPECT_ERROR(read("[]"), "expected an object");
  EXPECT_ERROR(read("{}"), "no \"format\"");
  EXPECT_ERROR(read("{\"format\": \"a\\nb\"}"), "is \"a\\x0ab\"");
  EXPECT_ERROR(read(R"({"format": "other", "version": 1, "frames": []})"), "\"format\" is \"other\"");
  EXPECT_ERROR(read(R"({"format": "ld-dataset", "frames": []})"), "no \"version\"");
  EXPECT_ERROR(read(R"({"format": "ld-dataset", "version": 2, "frames": []})"), "use a newer version");
  EXPECT_ERROR(read(R"({"format": "ld-dataset", "version": "1", "frames": []})"), "\"version\" is \"1\"");
  EXPECT_ERROR(read(R"({"format": "ld-dataset", "version": 1})"), "no \"frames\"");
  EXPECT_ERROR(read(R"({"format": "ld-dataset", "version": 1, "frames": [], "frames": []})"),
               "duplicate key \"frames\"");
  EXPECT_ERROR(read(R"({"format": "ld-dataset", "version": 1, "frame": []})"), "did you mean \"frames\"?");
  EXPECT_ERROR(read(R"({"format": "ld-dataset", "version": 1, "frames": [], "seed": -1})"), "\"seed\" is -1");
  EXPECT_ERROR(read(R"({"format": "ld-dataset", "version": 1, "frames": [], "recipe": 5})"),
               "\"recipe\" is number");
  EXPECT_ERROR(read(R"({"format": "ld-dataset", "version": 1, "frames": [], "schema": {"version": 99}})"),
               "schema 99");
  EXPECT_ERROR(
      read(
          R"({"format": "ld-dataset", "version": 1, "frames": [], "schema": {"version": 1, "features": 3}})"),
      "\"features\" is number");
  EXPECT_ERROR(read_frames("{}"), "\"frames\" is object");
  EXPECT_ERROR(read_frames("[3]"), "frames[0]: expected an object");
  EXPECT_ERROR(read_frames(R"([{"split": "train"}])"), "frames[0]: no \"name\"");
  EXPECT_ERROR(read_frames(R"([{"name": "a"}])"), "frames[0]: no \"split\"");
  EXPECT_ERROR(read_frames(R"([{"name": 4, "split": "train"}])"), "\"name\" is number");
  EXPECT_ERROR(read_frames(R"([{"name": "a", "split": "training"}])"),
               "\"training\"; expected one of train, validation, test");
  EXPECT_ERROR(read_frames(R"([{"name": "a", "splt": "train"}])"), "did you mean \"split\"?");
  EXPECT_ERROR(read_frames(R"([{"name": "a", "split": "train"}, {"name": "a", "split": "test"}])"),
               "stands twice");
  EXPECT_ERROR(read_frames(R"([{"name": "a", "split": "train", "index": 1.5}])"), "\"index\" is 1.5");
  EXPECT_ERROR(read_frames(R"([{"name": "a", "split": "train", "index": 18446744073709551615}])"),
               "\"index\"");
  EXPECT_ERROR(read_frames(R"([{"name": "a", "split": "train", "checksum": 1}])"), "\"checksum\" is number");
  for (const char* name : {"", "../a", "a/../b", "/etc/passwd", "a/", "a\\nb", ".."})
    EXPECT_ERROR(read_frames(fmt::format(R"([{{"name": "{}", "split": "train"}}])", name)),
                 "no file name inside");
  std::string deep;
  for (int i = 0; i < 100000; ++i) deep += "[";
  EXPECT_ERROR(read(deep), "deep");
}

TEST(Manifest, RefusesToMixRecipes) {
  const TemporaryFolder folder;
  add_to_manifest(folder.path(), one_frame(1));
  Manifest other = one_frame(2);
  other.recipe = "width: 16\n";
  EXPECT_ERROR(add_to_manifest(folder.path(), other), "another recipe");
  other = one_frame(2);
  other.seed = 5;
  EXPECT_ERROR(add_to_manifest(folder.path(), other), "seed");
  other = one_frame(2);
  other.frames[0].name = "../escape";
  EXPECT_ERROR(add_to_manifest(folder.path(), other), "no file name inside");
  other = one_frame(2, "testing");
  EXPECT_ERROR(add_to_manifest(folder.path(), other), "\"testing\"");
  EXPECT_EQ(read_manifest(folder.path()).frames.size(), 1u);
}

TEST(Manifest, ManyWritersLoseNothing) {
  const TemporaryFolder folder;
  constexpr int kProcesses = 3, kThreads = 2, kFrames = 4;
  std::vector<pid_t> children;
  for (int process = 0; process < kProcesses; ++process) {
    const pid_t child = fork();
    if (child == 0) {
      std::vector<std::thread> threads;
      for (int t = 0; t < kThreads; ++t)
        threads.emplace_back([&, t] {
          for (int i = 0; i < kFrames; ++i)
            add_to_manifest(folder.path(), one_frame((process * kThreads + t) * kFrames + i));
        });
      for (std::thread& thread : threads) thread.join();
      _exit(0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = -1;
    waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  const Manifest read = read_manifest(folder.path());
  ASSERT_EQ(read.frames.size(), size_t{kProcesses * kThreads * kFrames});
  for (size_t i = 0; i < read.frames.size(); ++i) EXPECT_EQ(read.frames[i].index, static_cast<int64_t>(i));
}

TEST(Manifest, SplitsAndVerification) {
  const TemporaryFolder folder;
  Manifest manifest;
  write_file_atomically(folder / "a.exr", "frame");
  write_file_atomically(folder / "a.reference.exr", "reference");
  manifest.frames = {{"a", "train", 0, checksum_text("frame", 5), checksum_text("reference", 9)},
                     {"b", "test", 1, "", ""}};
  add_to_manifest(folder.path(), manifest);
  EXPECT_EQ(frames_of_split(folder.path(), "train").size(), 1u);
  EXPECT_EQ(frames_of_split(folder.path(), "test")[0].name, "b");
  EXPECT_ERROR(frames_of_split(folder.path(), "validation"), "it has test (1), train (1)");
  verify_frame(folder.path(), manifest.frames[0]);
  EXPECT_ERROR(verify_frame(folder.path(), manifest.frames[1]), "b.exr: listed in the manifest");
  write_file_atomically(folder / "a.reference.exr", "Reference");
  EXPECT_ERROR(verify_frame(folder.path(), manifest.frames[0]), "a.reference.exr: checksum");
  manifest.frames[0].reference_checksum = "";
  verify_frame(folder.path(), manifest.frames[0]);
}

TEST(Manifest, RandomBytesGiveAManifestOrAnError) {
  const TemporaryFolder folder;
  add_to_manifest(folder.path(), one_frame(1));
  const std::string bytes = read_file(folder / "manifest.json");
  int errors = 0;
  for (uint32_t trial = 0; trial < 2000; ++trial) {
    RandomStream random(8, RandomPurpose::test, trial);
    std::string changed = bytes;
    for (uint32_t flips = 1 + random.below(3); flips > 0; --flips)
      changed[random.below(static_cast<uint32_t>(bytes.size()))] = static_cast<char>(random.bits());
    std::ofstream(folder / "manifest.json", std::ios::binary) << changed;
    SCOPED_TRACE("trial " + std::to_string(trial));
    try {
      EXPECT_EQ(read_manifest(folder.path()).frames.size(), 1u);
    } catch (const Error& error) {
      ++errors;
      EXPECT_NE(std::string(error.what()).find("manifest.json"), std::string::npos) << error.what();
    }
  }
  EXPECT_GT(errors, 1000);
}

}  // namespace
}  // namespace ld
