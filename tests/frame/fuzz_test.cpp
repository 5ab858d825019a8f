// Thousands of damaged frame files and manifests: each is read or gives one clear Error, soon and without
// taking the memory that a lying header asks for.
#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <gtest/gtest.h>
#include <half.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstring>

#include "core/file_io.h"
#include "core/random.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "tests/support/damage.h"
#include "tests/support/expect_error.h"
#include "tests/support/random_frame.h"
#include "tests/support/sanitized.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t kTrials = 2000;

void write_scan_lines(const fs::path& path, Imf::Compression compression) {
  Imf::Header header(9, 37);
  header.compression() = compression;
  std::vector<half> pixels(size_t{9} * 37);
  for (size_t i = 0; i < pixels.size(); ++i) pixels[i] = half(static_cast<float>(i % 17) * 0.1F);
  Imf::FrameBuffer buffer;
  for (const char* channel : {"R", "G", "B"}) {
    header.channels().insert(channel, Imf::Channel(Imf::HALF));
    buffer.insert(channel, Imf::Slice::Make(Imf::HALF, pixels.data(), header.dataWindow()));
  }
  Imf::OutputFile file(path.c_str(), header);
  file.setFrameBuffer(buffer);
  file.writePixels(37);
}

/// Files of every kind that is read: frames and images of each compression.
std::vector<std::string> good_files(const fs::path& folder) {
  std::vector<std::string> files;
  for (const int size : {3, 70}) {  // one tile and several
    write_frame(folder / "good.exr", random_frame(size, 2, 2));
    files.push_back(read_file(folder / "good.exr"));
  }
  for (int compression = 0; compression < Imf::NUM_COMPRESSION_METHODS; ++compression) {
    write_scan_lines(folder / "good.exr", static_cast<Imf::Compression>(compression));
    files.push_back(read_file(folder / "good.exr"));
  }
  return files;
}

/// Reads a file in the ways that programs do; an Error must name it. False when there was one.
bool read_whole(const fs::path& path, bool samples) {
  try {
    if (samples) {
      Faults faults;
      const FrameHeader header = read_frame_header(path);
      const Frame frame = read_frame(path, {}, faults);
      EXPECT_EQ(frame.width, header.width);
      EXPECT_EQ(frame.samples.size(), frame.valid.size() * kSampleChannels);
    } else {
      EXPECT_GT(read_image(path).pixels.size(), 0u);
    }
    return true;
  } catch (const Error& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find(path.filename().string()), std::string::npos) << text;
    EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    return false;
  }
}

TEST(Fuzz, DamagedFramesAreReadOrGiveOneError) {
  const TemporaryFolder folder;
  const std::vector<std::string> files = good_files(folder.path());
  const fs::path path = folder / "fuzz.exr";
  int errors = 0;
  run_trials(kTrials, [&](uint32_t number, RandomStream& random) {
    // Frames, which are what a data set consists of, half of the time.
    const size_t file = number % 2 == 0 ? number / 2 % 2 : 2 + number / 2 % (files.size() - 2);
    write_new_file(path, damaged(files[file], random));
    if (!read_whole(path, file < 2)) ++errors;
  });
  EXPECT_GT(errors, 1000);
  EXPECT_LT(errors, 2000) << "some damages do no harm";
}

TEST(Fuzz, DamagedManifestsAreReadOrGiveOneError) {
  const TemporaryFolder folder;
  Manifest manifest;
  manifest.recipe = "resolution: [8, 8]\n";
  manifest.seed = 5;
  for (int i = 0; i < 4; ++i) {
    ManifestFrame& entry = manifest.frames.emplace_back();
    entry.name = "frame_00000" + std::to_string(i);
    entry.split = i == 0 ? "test" : "train";
    entry.index = i;
    entry.checksum = "0123456789abcdef";
  }
  add_to_manifest(folder.path(), manifest);
  const std::string good = read_file(folder / "manifest.json");
  int errors = 0;
  run_trials(kTrials, [&](uint32_t number, RandomStream& random) {
    std::string bytes = number % 2 == 0 ? damaged(good, random) : other_token(good, random);
    if (number % 4 == 3) bytes = other_token(bytes, random);
    write_new_file(folder / "manifest.json", bytes);
    try {
      for (const ManifestFrame& frame : read_manifest(folder.path()).frames) {
        const std::string text = error_text([&] { verify_frame(folder.path(), frame); });
        EXPECT_NE(text.find("no such file"), std::string::npos) << text;
      }
    } catch (const Error& error) {
      ++errors;
      const std::string text = error.what();
      EXPECT_NE(text.find("manifest.json"), std::string::npos) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    }
  });
  EXPECT_GT(errors, 1000);
  EXPECT_LT(errors, 2000);
}

/// Kilobytes that reading adds to the largest memory of a process of its own; -1 when it fails.
int64_t growth_of(const std::function<void()>& reading) {
  int ends[2];
  if (pipe(ends) != 0) return -1;
  const pid_t process = fork();
  if (process == 0) {
    rusage before{}, after{};
    getrusage(RUSAGE_SELF, &before);
    reading();
    getrusage(RUSAGE_SELF, &after);
    const int64_t kilobytes = after.ru_maxrss - before.ru_maxrss;
    const bool written = write(ends[1], &kilobytes, sizeof kilobytes) == sizeof kilobytes;
    _exit(written && !testing::Test::HasFailure() ? 0 : 1);
  }
  close(ends[1]);
  int64_t kilobytes = -1;
  if (read(ends[0], &kilobytes, sizeof kilobytes) != sizeof kilobytes) kilobytes = -1;
  close(ends[0]);
  int status = 0;
  waitpid(process, &status, 0);
  return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? kilobytes : -1;
}

/// Puts `value` at `skip` bytes of the value of the first attribute `name`.
void put(std::string& bytes, const std::string& name, const std::string& type, size_t skip, int32_t value) {
  const std::string key = name + '\0' + type + '\0';
  const size_t at = bytes.find(key);
  if (at != std::string::npos) std::memcpy(bytes.data() + at + key.size() + 4 + skip, &value, sizeof value);
}

/// A file whose header declares `width` x `height`, with a table of chunks as long as that takes, all of
/// whose entries but the first point at the first chunk.
std::string lying_file(const fs::path& folder, Imf::Compression compression, int lines, int width,
                       int height) {
  write_scan_lines(folder / "lie.exr", compression);
  std::string bytes = read_file(folder / "lie.exr");
  put(bytes, "dataWindow", "box2i", 8, width - 1);
  put(bytes, "dataWindow", "box2i", 12, height - 1);
  const int old_chunks = (37 + lines - 1) / lines, chunks = (height + lines - 1) / lines;
  // The table of offsets follows the header, and its first entry names the byte behind the table.
  size_t table = 0;
  for (size_t at = 8; at + 8 <= bytes.size() && table == 0; ++at) {
    uint64_t entry = 0;
    std::memcpy(&entry, bytes.data() + at, sizeof entry);
    if (entry == at + 8 * static_cast<size_t>(old_chunks)) table = at;
  }
  EXPECT_GT(table, 0u);
  const std::string chunk = bytes.substr(table + 8 * static_cast<size_t>(old_chunks));
  bytes.resize(table);
  const uint64_t offset = table + 8 * static_cast<size_t>(chunks);
  for (int i = 0; i < chunks; ++i) bytes.append(reinterpret_cast<const char*>(&offset), sizeof offset);
  return bytes + chunk;
}

TEST(Fuzz, SmallFilesThatDeclareHugeImagesTakeNoMemory) {
  if (kAddressSanitizer) GTEST_SKIP() << "the sanitizer's own memory would be measured";
  const TemporaryFolder folder;
  const std::vector<std::string> files = good_files(folder.path());
  const fs::path path = folder / "huge.exr";
  const auto expect_little = [&](const std::string& what, const std::string& bytes) {
    write_new_file(path, bytes);
    for (const bool samples : {false, true}) {
      const int64_t kilobytes = growth_of([&] { read_whole(path, samples); });
      EXPECT_GE(kilobytes, 0) << what;
      EXPECT_LT(kilobytes, 64 * 1024) << what << ", " << bytes.size() << " bytes";
    }
  };
  // Every compression with a window that its limit lets pass, and with one that none does.
  const int lines[] = {1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
  for (int compression = 0; compression < Imf::NUM_COMPRESSION_METHODS; ++compression)
    for (const auto& [width, height] :
         {std::pair<int, int>{16384, 16384}, {16384, 512}, {4096, 4096}, {9, 16384}})
      expect_little(fmt::format("compression {}, {} x {}", compression, width, height),
                    lying_file(folder.path(), static_cast<Imf::Compression>(compression), lines[compression],
                               width, height));
  // Tiles, and windows of frames of samples.
  for (const int side : {4096, 4097, 16384, INT32_MAX}) {
    for (const std::string& file : {files[0], files[1]}) {
      std::string bytes = file;
      put(bytes, "tiles", "tiledesc", 0, side);
      put(bytes, "tiles", "tiledesc", 4, side);
      expect_little(fmt::format("tiles of {}", side), bytes);
      bytes = file;
      put(bytes, "dataWindow", "box2i", 8, side - 1);
      put(bytes, "dataWindow", "box2i", 12, side - 1);
      expect_little(fmt::format("a window of {}", side), bytes);
      put(bytes, "tiles", "tiledesc", 0, 4096);
      put(bytes, "tiles", "tiledesc", 4, 4096);
      expect_little(fmt::format("a window of {} in one tile", side), bytes);
    }
  }
  // The damaged files of the other test, all in one process: what any of them takes adds up to the largest.
  const int64_t kilobytes = growth_of([&] {
    for (uint32_t number = 0; number < 500; ++number) {
      RandomStream random(8, RandomPurpose::test, number);
      std::string bytes = files[number % files.size()];
      for (int i = 0; i < 3; ++i) write_number(bytes, random, 600);
      write_new_file(path, bytes);
      read_whole(path, number % 2 == 0);
    }
  });
  EXPECT_GE(kilobytes, 0);
  EXPECT_LT(kilobytes, 64 * 1024);
}

}  // namespace
}  // namespace ld
