// The reader here shares nothing with the writer: records, both checksums, fields of the messages.
#include "training/run/tensorboard.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <cstring>
#include <map>
#include <optional>

#include "core/file_io.h"
#include "frame/frame_file.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

namespace fs = std::filesystem;

/// CRC-32C by polynomial division, bit by bit.
uint32_t slow_crc32c(const std::string& bytes) {
  uint32_t crc = ~0U;
  for (const char byte : bytes)
    for (int bit = 0; bit < 8; ++bit) {
      const bool low = ((crc ^ static_cast<uint32_t>(static_cast<uint8_t>(byte) >> bit)) & 1) != 0;
      crc = (crc >> 1) ^ (low ? 0x82f63b78U : 0U);
    }
  return ~crc;
}

template <class Number>
Number number_at(const std::string& bytes, size_t at) {
  Number number{};
  EXPECT_LE(at + sizeof number, bytes.size());
  if (at + sizeof number <= bytes.size()) std::memcpy(&number, bytes.data() + at, sizeof number);
  return number;
}

uint32_t masked(const std::string& bytes) {
  const uint32_t crc = slow_crc32c(bytes);
  return ((crc >> 15) | (crc << 17)) + 0xa282ead8U;
}

std::vector<std::string> records_of(const fs::path& path) {
  const std::string bytes = read_file(path);
  std::vector<std::string> records;
  size_t at = 0;
  while (at < bytes.size() && !testing::Test::HasFailure()) {
    const auto length = number_at<uint64_t>(bytes, at);
    EXPECT_EQ(number_at<uint32_t>(bytes, at + 8), masked(bytes.substr(at, 8)));
    records.push_back(bytes.substr(at + 12, length));
    EXPECT_EQ(number_at<uint32_t>(bytes, at + 12 + length), masked(records.back()));
    at += 16 + length;
  }
  EXPECT_EQ(at, bytes.size());
  return records;
}

/// The fields of a message: numbers as text, of varints; bytes of all others.
std::map<int, std::string> fields_of(const std::string& message) {
  std::map<int, std::string> fields;
  size_t at = 0;
  const auto varint = [&] {
    uint64_t value = 0;
    for (int shift = 0; shift < 70; shift += 7) {
      const auto byte = number_at<uint8_t>(message, at++);
      value |= static_cast<uint64_t>(byte & 0x7f) << shift;
      if (byte < 0x80) break;
    }
    return value;
  };
  while (at < message.size()) {
    const uint64_t key = varint();
    const uint64_t type = key & 7;
    std::string& value = fields[static_cast<int>(key >> 3)];
    if (type == 0) {
      value = std::to_string(static_cast<int64_t>(varint()));
      continue;
    }
    const uint64_t size = type == 1 ? 8 : type == 5 ? 4 : varint();
    EXPECT_TRUE(type == 1 || type == 2 || type == 5) << type;
    EXPECT_LE(at + size, message.size());
    value = message.substr(at, size);
    at += size;
  }
  return fields;
}

/// The one value of an event's summary.
std::map<int, std::string> value_of(const std::string& event) {
  return fields_of(fields_of(fields_of(event).at(5)).at(1));
}

TEST(EventFile, AnotherReaderFindsEveryRecord) {
  EXPECT_EQ(slow_crc32c("123456789"), 0xe3069283U);  // the standard's check value
  const TemporaryFolder folder;
  Image picture(5, 3, 3);
  for (size_t i = 0; i < picture.pixels.size(); ++i) picture.pixels[i] = 0.03F * static_cast<float>(i);
  EventFile file(folder / "run", 40);
  file.scalar(50, "train/loss", 0.125);
  file.scalar(300, "validation/psnr", std::nan(""));
  file.scalar(int64_t{1} << 40, "train/loss", -1e30);
  file.image(300, "validation/frame_1", picture);

  const std::vector<std::string> records = records_of(file.path());
  ASSERT_EQ(records.size(), 6u);
  EXPECT_EQ(file.path().filename(), "events.out.tfevents.000001");
  EXPECT_EQ(fields_of(records[0]).at(3), "brain.Event:2");
  const double now =
      std::chrono::duration<double>(std::chrono::system_clock::now().time_since_epoch()).count();
  for (const std::string& record : records)
    EXPECT_NEAR(number_at<double>(fields_of(record).at(1), 0), now, 60);
  EXPECT_EQ(fields_of(records[1]).at(2), "41") << "what a resumed run does again";
  EXPECT_EQ(fields_of(fields_of(records[1]).at(7)).at(1), "1") << "SessionLog START";

  EXPECT_EQ(fields_of(records[2]).at(2), "50");
  EXPECT_EQ(value_of(records[2]).at(1), "train/loss");
  EXPECT_EQ(number_at<float>(value_of(records[2]).at(2), 0), 0.125F);
  EXPECT_TRUE(std::isnan(number_at<float>(value_of(records[3]).at(2), 0)));
  EXPECT_EQ(fields_of(records[4]).at(2), std::to_string(int64_t{1} << 40));
  EXPECT_EQ(number_at<float>(value_of(records[4]).at(2), 0), -1e30F);

  const std::map<int, std::string> image = fields_of(value_of(records[5]).at(4));
  EXPECT_EQ(image.at(1), "3");  // height
  EXPECT_EQ(image.at(2), "5");
  EXPECT_EQ(image.at(3), "3");  // channels
  write_image(folder / "same.png", picture);
  EXPECT_EQ(image.at(4), read_file(folder / "same.png"));
}

TEST(EventFile, EachStartHasAFileOfItsOwnBehindTheOthers) {
  const TemporaryFolder folder;
  std::vector<std::string> names;
  for (const int64_t step : {0, 10, 20}) {
    const EventFile file(folder.path(), step);
    names.push_back(file.path().filename().string());
    EXPECT_EQ(fields_of(records_of(file.path()).at(1)).at(2), std::to_string(step + 1));
  }
  EXPECT_EQ(names, (std::vector<std::string>{"events.out.tfevents.000001", "events.out.tfevents.000002",
                                             "events.out.tfevents.000003"}));
}

/// Files of this process may not grow beyond so many bytes, as on a disk that is full.
class SmallDisk {
 public:
  explicit SmallDisk(rlim_t bytes) {
    getrlimit(RLIMIT_FSIZE, &before_);
    handler_ = signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {bytes, before_.rlim_max};
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~SmallDisk() {
    setrlimit(RLIMIT_FSIZE, &before_);
    signal(SIGXFSZ, handler_);
  }
  SmallDisk(const SmallDisk&) = delete;
  SmallDisk& operator=(const SmallDisk&) = delete;

 private:
  rlimit before_ = {};
  sighandler_t handler_ = nullptr;
};

TEST(EventFile, AFullDiskLeavesWholeRecordsAndWritingGoesOn) {
  const TemporaryFolder folder;
  EventFile file(folder.path(), 0);
  file.scalar(1, "loss", 1);
  const size_t whole = fs::file_size(file.path());
  {
    const SmallDisk disk(whole + 20);  // in the middle of the next record
    EXPECT_ERROR(file.scalar(2, "loss", 2), "events.out.tfevents.000001: File too large");
    EXPECT_EQ(fs::file_size(file.path()), whole);
    EXPECT_ERROR(file.scalar(3, "loss", 3), "File too large");
  }
  file.scalar(4, "loss", 4);
  const std::vector<std::string> records = records_of(file.path());
  ASSERT_EQ(records.size(), 4u);
  EXPECT_EQ(fields_of(records[3]).at(2), "4");
  EXPECT_ERROR(EventFile("/proc/self/none", 0), "/proc/self/none");
}

}  // namespace
}  // namespace ld
