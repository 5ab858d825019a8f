#include "training/run/tensorboard.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <cstring>

#include "core/error.h"
#include "core/file_io.h"
#include "frame/frame_file.h"

namespace ld {
namespace fs = std::filesystem;
namespace {

constexpr const char* kPrefix = "events.out.tfevents.";

/// CRC-32C (Castagnoli), reflected, one byte at a time.
uint32_t crc32c(const std::string& bytes) {
  static const std::array<uint32_t, 256> table = [] {
    std::array<uint32_t, 256> entries{};
    for (uint32_t i = 0; i < 256; ++i) {
      uint32_t value = i;
      for (int bit = 0; bit < 8; ++bit) value = value >> 1 ^ ((value & 1) != 0 ? 0x82f63b78U : 0);
      entries[i] = value;
    }
    return entries;
  }();
  uint32_t crc = 0xffffffffU;
  for (const char byte : bytes) crc = crc >> 8 ^ table[(crc ^ static_cast<uint8_t>(byte)) & 0xff];
  return ~crc;
}

template <class Number>
std::string little_endian(Number number) {  // as are the machines this project supports
  std::string bytes(sizeof number, '\0');
  std::memcpy(bytes.data(), &number, sizeof number);
  return bytes;
}

/// TFRecord's masked checksum: that of data which holds checksums itself would be weak.
std::string masked_crc(const std::string& bytes) {
  const uint32_t crc = crc32c(bytes);
  return little_endian((crc >> 15 | crc << 17) + 0xa282ead8U);
}

/// Protocol buffers' wire format: a key of field number and type, then the value.
std::string varint(uint64_t value) {
  std::string bytes;
  for (; value >= 0x80; value >>= 7) bytes += static_cast<char>(value | 0x80);
  return bytes + static_cast<char>(value);
}
std::string key(int field, int type) {
  return varint(static_cast<uint64_t>(field << 3 | type));
}
std::string field(int number, int64_t value) {
  return key(number, 0) + varint(static_cast<uint64_t>(value));
}
std::string field(int number, double value) {
  return key(number, 1) + little_endian(value);
}
std::string field(int number, const std::string& value) {
  return key(number, 2) + varint(value.size()) + value;
}
std::string field(int number, float value) {
  return key(number, 5) + little_endian(value);
}

/// An Event: wall_time, step and what happened.
std::string make_event(int64_t step, const std::string& what) {
  const std::chrono::duration<double> now = std::chrono::system_clock::now().time_since_epoch();
  return field(1, now.count()) + field(2, step) + what;
}

/// An Event's summary of one value: its tag and what follows.
std::string make_summary(const std::string& tag, const std::string& value) {
  return field(5, field(1, field(1, tag) + value));
}

/// TensorBoard reads the files of a folder in the order of their names.
fs::path next_path(const fs::path& folder) {
  int highest = 0;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind(kPrefix, 0) != 0) continue;
    const std::string digits = name.substr(std::strlen(kPrefix));
    int number = 0;
    std::from_chars(digits.data(), digits.data() + digits.size(), number);
    highest = std::max(highest, number);
  }
  return folder / fmt::format("{}{:06}", kPrefix, highest + 1);
}

}  // namespace

EventFile::EventFile(const fs::path& folder, int64_t step) {
  make_folder(folder);
  path_ = next_path(folder);
  file_ = open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC, 0644);
  if (file_ < 0) fail("cannot make {}: {}", path_.string(), std::strerror(errno));
  try {
    append(make_event(step, field(3, std::string("brain.Event:2"))));
    // A session log that says START (1): TensorBoard forgets what earlier files hold from this step on.
    append(make_event(step + 1, field(7, field(1, int64_t{1}))));
  } catch (const Error&) {
    close(file_);
    throw;
  }
}

EventFile::~EventFile() {
  close(file_);
}

void EventFile::scalar(int64_t step, const std::string& tag, double value) {
  append(make_event(step, make_summary(tag, field(2, static_cast<float>(value)))));
}

void EventFile::image(int64_t step, const std::string& tag, const Image& image) {
  const std::string pixels = field(1, int64_t{image.height}) + field(2, int64_t{image.width}) +
                             field(3, int64_t{image.channels}) + field(4, png_bytes(path_, image));
  append(make_event(step, make_summary(tag, field(4, pixels))));
}

void EventFile::append(const std::string& event) {
  const std::string length = little_endian(uint64_t{event.size()});
  const std::string record = length + masked_crc(length) + event + masked_crc(event);
  for (size_t done = 0; done < record.size();) {
    const ssize_t written = write(file_, record.data() + done, record.size() - done);
    if (written > 0) {
      done += static_cast<size_t>(written);
    } else if (written == 0 || errno != EINTR) {
      const int reason = errno;
      // What could not be cut off would end the file for its readers; there is nothing left to try.
      const bool cut = ftruncate(file_, whole_) == 0;
      fail("cannot append to {}: {}{}", path_.string(), std::strerror(reason),
           cut ? "" : " (its last record is incomplete)");
    }
  }
  whole_ += static_cast<int64_t>(record.size());
}

}  // namespace ld
