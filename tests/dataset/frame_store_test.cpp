#include "dataset/frame_store.h"

#include <gtest/gtest.h>
#include <spdlog/sinks/ostream_sink.h>

#include <fstream>
#include <sstream>
#include <thread>

#include "core/error.h"
#include "core/file_io.h"
#include "core/log.h"
#include "dataset/augmentation.h"
#include "tests/support/expect_error.h"
#include "tests/support/packed_crop.h"
#include "tests/support/temporary_folder.h"
#include "tests/support/tiny_dataset.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// Catches the log while it lives.
class Log {
 public:
  Log() : before_(spdlog::default_logger()) {
    spdlog::set_default_logger(
        std::make_shared<spdlog::logger>("test", std::make_shared<spdlog::sinks::ostream_sink_mt>(text_)));
  }
  ~Log() { spdlog::set_default_logger(before_); }
  /// How often the text stands in the log.
  int count(const std::string& part) const {
    const std::string text = text_.str();
    int found = 0;
    for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++found;
    return found;
  }
  std::string text() const { return text_.str(); }

 private:
  std::ostringstream text_;
  std::shared_ptr<spdlog::logger> before_;
};

const std::vector<std::string> kFeatures = {"normal", "radiance", "depth"};

CacheOptions options(const std::string& folder = "", uint64_t memory = 0, uint64_t reserve = 0) {
  return {folder, memory, reserve};
}

class FrameStoreTest : public testing::Test {
 protected:
  void SetUp() override { write_tiny_dataset(data(), 4, 37, 3); }
  fs::path data() const { return folder_ / "data"; }
  fs::path reference() const { return reference_path(data(), "frame_0"); }

  /// All values of a frame, read through a store of its own.
  static std::vector<float> values(FrameStore& store, size_t index) {
    const Augmentation whole = whole_frame(store.width(index), store.height(index), true, false, 1);
    const auto frame = store.get_intact(index, store.get(index), whole.tiles());
    const CropOfFrame crop = crop_of(*frame, whole);
    std::vector<float> all(crop.frame.samples.begin(), crop.frame.samples.end());
    all.insert(all.end(), crop.radiance.begin(), crop.radiance.end());
    all.insert(all.end(), crop.reference.pixels.begin(), crop.reference.pixels.end());
    return all;
  }
  std::vector<float> values(const CacheOptions& cache, size_t index = 0) {
    FrameStore store(data(), "train", kFeatures, cache);
    return values(store, index);
  }
  static std::vector<fs::path> files(const fs::path& folder) {
    std::vector<fs::path> found;
    if (fs::exists(folder))
      for (const auto& entry : fs::recursive_directory_iterator(folder))
        if (entry.is_regular_file()) found.push_back(entry.path());
    std::sort(found.begin(), found.end());
    return found;
  }
  fs::path only_file() const {
    const std::vector<fs::path> found = files(data() / ".cache");
    EXPECT_EQ(found.size(), 1u);
    return found.at(0);
  }
  /// The time of change is part of what is compared, and the clock of a disk may be slow.
  static void touch(const fs::path& path) {
    fs::last_write_time(path, fs::last_write_time(path) + std::chrono::seconds(2));
  }

  TemporaryFolder folder_;
};

TEST_F(FrameStoreTest, CacheFilesMemoryAndFramesGiveTheSameBits) {
  const std::vector<float> plain = values(options("none"));
  EXPECT_TRUE(files(data() / ".cache").empty());
  const std::vector<float> made = values(options());
  EXPECT_EQ(only_file().filename(), "frame_0.safetensors");
  const auto written = fs::last_write_time(only_file());
  const std::vector<float> mapped = values(options());
  EXPECT_EQ(fs::last_write_time(only_file()), written);
  EXPECT_EQ(made, plain);
  EXPECT_EQ(mapped, plain);

  FrameStore memory(data(), "train", kFeatures, options("none", 1 << 20));
  EXPECT_EQ(values(memory, 0), plain);
  EXPECT_EQ(memory.get(0), memory.get(0)) << "kept";
  FrameStore no_memory(data(), "train", kFeatures, options("none", 0));
  EXPECT_NE(no_memory.get(0), no_memory.get(0));
}

TEST_F(FrameStoreTest, HoldsTheFeaturesThatAreAskedForAndKeepsThemApart) {
  FrameStore few(data(), "train", {"depth"}, options());
  EXPECT_EQ(few.get(0)->features, (std::vector<std::string>{"radiance", "depth"}));
  EXPECT_EQ(few.get(0)->features, (std::vector<std::string>{"radiance", "depth"})) << "mapped";
  FrameStore more(data(), "train", kFeatures, options());
  EXPECT_EQ(more.get(0)->channels(), 7);
  FrameStore same(data(), "train", {"depth", "normal"}, options());  // another order, the same file
  same.get(0);
  EXPECT_EQ(files(data() / ".cache").size(), 2u);
}

TEST_F(FrameStoreTest, AChangedFrameOrReferenceIsReadAgain) {
  const std::vector<float> before = values(options());
  Frame frame = random_frame(37, 37, 3, 77);
  write_frame(frame_path(data(), "frame_0"), frame);
  touch(frame_path(data(), "frame_0"));
  const std::vector<float> after = values(options());
  EXPECT_NE(after, before);
  EXPECT_EQ(after, values(options("none")));

  write_image(reference(), mean_radiance(frame));
  touch(reference());
  EXPECT_EQ(values(options()), values(options("none")));
  EXPECT_NE(values(options()), after);

  // Another size and another number of samples.
  frame = random_frame(20, 40, 1, 78);
  write_frame(frame_path(data(), "frame_0"), frame);
  write_image(reference(), mean_radiance(frame));
  EXPECT_EQ(values(options()), values(options("none")));
}

TEST_F(FrameStoreTest, DamagedFilesAreReportedAndMadeAgain) {
  const std::vector<float> expected = values(options());
  const std::string good = read_file(only_file());
  const size_t header = 8 + static_cast<size_t>(*reinterpret_cast<const uint64_t*>(good.data()));
  const auto with_byte = [&](size_t at) {
    std::string changed = good;
    changed[at] = static_cast<char>(changed[at] ^ 1);  // of a digit, another digit
    return changed;
  };
  const std::map<std::string, std::string> damaged = {
      {"cut short", good.substr(0, good.size() / 2)},
      {"empty", ""},
      {"no header", std::string(good.size(), '\0')},
      {"another format", "no cache file at all"},
      {"index", with_byte(header + 5)},
      {"samples", with_byte(good.size() / 2)},
      {"mask", with_byte(good.size() - 1)},
      {"width", with_byte(good.find("\"width\":\"37") + 9)},
      {"spp", with_byte(good.find("\"spp\":\"3") + 7)},
      {"scale", with_byte(good.find("\"depth_scale\":\"") + 17)}};
  for (const auto& [name, bytes] : damaged) {
    SCOPED_TRACE(name);
    std::ofstream(only_file(), std::ios::binary) << bytes;
    const Log log;
    EXPECT_EQ(values(options()), expected);
    EXPECT_EQ(log.count("damaged cache file"), 1) << log.text();
    EXPECT_TRUE(read_file(only_file()) == good);
    EXPECT_EQ(values(options()), expected);
    EXPECT_EQ(log.count("damaged cache file"), 1) << log.text();
  }
}

TEST_F(FrameStoreTest, DamageIsNoticedInTheSamplesThatAreReadAlone) {
  values(options());
  const std::string good = read_file(only_file());
  FrameStore store(data(), "train", kFeatures, options());
  const Augmentation whole = whole_frame(37, 37);
  EXPECT_EQ(store.spp(0), 3);
  std::string bad = good;
  {
    const auto frame = store.get(0);
    const uint16_t* second = frame->samples + static_cast<size_t>(frame->channels()) * kTilePixels;
    const std::string bytes(reinterpret_cast<const char*>(second), 64);
    bad[good.find(bytes) + 5] ^= 1;
  }
  std::ofstream(only_file(), std::ios::binary) << bad;
  const Log log;
  for (const SampleList& samples : {SampleList{0}, SampleList{2}, SampleList{0, 2}})
    store.get_intact(0, store.get(0), whole.tiles(), samples);
  EXPECT_EQ(log.count("damaged cache file"), 0) << log.text();
  EXPECT_TRUE(read_file(only_file()) == bad);
  store.get_intact(0, store.get(0), whole.tiles(), {1});
  EXPECT_EQ(log.count("damaged cache file"), 1) << log.text();
  EXPECT_TRUE(read_file(only_file()) == good);
}

TEST_F(FrameStoreTest, WhereNothingCanBeWrittenOneWarningAndTheFrames) {
  std::ofstream(folder_ / "file") << "x";
  const std::vector<float> expected = values(options("none"));
  // Below a file no folder can be made; and a disk with less than its reserve free counts as full.
  for (const CacheOptions& bad :
       {options((folder_ / "file" / "cache").string()), options("", 0, uint64_t{1} << 60)}) {
    const Log log;
    FrameStore store(data(), "train", kFeatures, bad);
    for (int epoch = 0; epoch < 2; ++epoch)
      for (size_t i = 0; i < store.size(); ++i) values(store, i);
    EXPECT_EQ(values(store, 0), expected);
    EXPECT_EQ(log.count("frames are not cached from here on"), 1) << log.text();
    EXPECT_TRUE(files(data() / ".cache").empty());
  }
}

TEST_F(FrameStoreTest, FilesThatAreThereAreUsedOnAFullDisk) {
  const std::vector<float> expected = values(options());
  const Log log;
  EXPECT_EQ(values(options("", 0, uint64_t{1} << 60)), expected);
  EXPECT_EQ(log.count("not cached"), 0) << log.text();
}

TEST_F(FrameStoreTest, ASharedFolderKeepsDataSetsApart) {
  write_tiny_dataset(folder_ / "other", 1, 20, 1);
  const std::string shared = (folder_ / "shared").string();
  FrameStore first(data(), "train", kFeatures, options(shared)),
      second(folder_ / "other", "train", kFeatures, options(shared));
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ(first.get(0)->width, 37);
    EXPECT_EQ(second.get(0)->width, 20);
  }
  EXPECT_EQ(files(shared).size(), 2u);
}

TEST_F(FrameStoreTest, ThreadsShareAStore) {
  FrameStore store(data(), "train", kFeatures, options());
  std::vector<std::vector<float>> found(8);
  std::vector<std::thread> threads;
  for (size_t t = 0; t < found.size(); ++t)
    threads.emplace_back([&, t] {
      for (size_t i = 0; i < store.size(); ++i) found[t] = values(store, i);
    });
  for (std::thread& thread : threads) thread.join();
  for (const std::vector<float>& one : found) EXPECT_EQ(one, found[0]);
  EXPECT_EQ(files(data() / ".cache").size(), 4u);
}

TEST_F(FrameStoreTest, BadDataIsAnErrorNotAWarning) {
  EXPECT_ERROR(FrameStore(data(), "holdout", kFeatures, options()), "no frames of the split 'holdout'");
  EXPECT_ERROR(FrameStore(data(), "train", {"flow"}, options()), "lacks the feature 'flow'");
  FrameStore store(data(), "train", kFeatures, options());
  write_image(reference(), Image(5, 5, 3));
  EXPECT_ERROR(store.get(0), "both must show the same picture");
  fs::remove(reference());
  EXPECT_ERROR(store.get(0), "frame_0.reference.exr");
}

}  // namespace
}  // namespace ld
