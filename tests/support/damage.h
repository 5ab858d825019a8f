// Ways to damage a file, chosen at random: for tests of whoever reads files that may be damaged or hostile.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "core/random.h"

namespace ld {

inline uint32_t below(RandomStream& random, size_t count) {
  return random.below(static_cast<uint32_t>(std::max<size_t>(count, 1)));
}

/// Numbers that break arithmetic.
inline void write_number(std::string& bytes, RandomStream& random, size_t limit) {
  static const int64_t numbers[] = {0,         1,          -1,      2,         255,       65535,
                                    65536,     16384,      16385,   INT32_MAX, INT32_MIN, INT64_MAX,
                                    INT64_MIN, 0x7ffffff0, 1 << 30, 4096};
  const int64_t number = numbers[below(random, std::size(numbers))];
  const size_t size = random.below(2) == 0 ? 4 : 8;
  if (bytes.size() < size) return;
  std::memcpy(bytes.data() + below(random, std::min(bytes.size() - size + 1, limit)), &number, size);
}

/// One to four damages: bytes changed, cut off, inserted, doubled, taken out, numbers replaced.
inline std::string damaged(const std::string& good, RandomStream& random) {
  std::string bytes = good;
  for (uint32_t more = 1 + random.below(4); more > 0; --more) {
    const size_t at = below(random, bytes.size()),
                 length = below(random, std::min<size_t>(bytes.size(), 400));
    switch (random.below(8)) {
      case 0:
        bytes.resize(at);
        break;
      case 1:
        bytes.insert(at, std::string(length, static_cast<char>(random.bits())));
        break;
      case 2:
        bytes.insert(at, bytes.substr(below(random, bytes.size()), length));
        break;
      case 3:
        bytes.erase(at, length);
        break;
      case 4:
        write_number(bytes, random, bytes.size());
        break;
      case 5:
        write_number(bytes, random, 600);  // within the header of the small files here
        break;
      case 6:
        if (!bytes.empty()) bytes[at] = static_cast<char>(bytes[at] ^ (1 << random.below(8)));
        break;
      default:
        if (!bytes.empty()) bytes[at] = static_cast<char>(random.bits());
    }
  }
  return bytes;
}

/// Replaces one JSON token by another.
inline std::string other_token(const std::string& text, RandomStream& random) {
  static const char* tokens[] = {"null",
                                 "true",
                                 "-1",
                                 "1e999",
                                 "18446744073709551616",
                                 "9223372036854775808",
                                 "0.5",
                                 "\"\"",
                                 "\"..\"",
                                 "\"a/../../b\"",
                                 "\"/etc/passwd\"",
                                 "[]",
                                 "{}",
                                 "[[[[]]]]",
                                 "\"\\u0000\"",
                                 "\"\\ud800\"",
                                 "\"train\"",
                                 "2",
                                 "\xff",
                                 "\"name\"",
                                 ",",
                                 ":"};
  const std::string ends = " ,:[]{}\n";
  const size_t start = text.find_first_not_of(ends, below(random, text.size()));
  if (start == std::string::npos) return text;
  const size_t end = std::min(text.find_first_of(ends, start), text.size());
  std::string changed = text;
  std::string token = tokens[below(random, std::size(tokens))];
  if (random.below(20) == 0)
    token = "\"" + std::string(5000, 'n') + "\"";  // longer than names of files may be
  if (random.below(20) == 0) token = std::string(5000, random.below(2) == 0 ? '[' : '{');
  return changed.replace(start, end - start, token);
}

/// A file made anew: where one is cut to nothing and written again, ext4 waits for the disk.
inline void write_new_file(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::remove(path);
  std::ofstream(path, std::ios::binary) << bytes;
}

/// Runs trial(number, random) for so many numbers, none of them longer than two seconds; ends at the first
/// failure and names its number.
template <class Trial>
void run_trials(uint32_t trials, const Trial& trial) {
  for (uint32_t number = 0; number < trials; ++number) {
    SCOPED_TRACE("trial " + std::to_string(number));
    RandomStream random(7, RandomPurpose::test, number);
    const auto start = std::chrono::steady_clock::now();
    trial(number, random);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_LT(seconds, 2);
    if (testing::Test::HasFailure()) return;
  }
}

/// What somebody reads who opened a damaged file: one line, not too long, that names the file.
inline void expect_clear(const std::string& text, const std::string& name) {
  EXPECT_NE(text.find(name), std::string::npos) << text;
  EXPECT_LT(text.size(), 700u) << text;
  EXPECT_TRUE(std::all_of(text.begin(), text.end(), [](char c) {
    return static_cast<unsigned char>(c) >= 32;
  })) << text;
}

}  // namespace ld
