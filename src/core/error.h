// The two ways a program of this project fails. Every message says what is wrong, where, what was expected,
// what was found and what to do about it.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace ld {

/// A failure while running (missing file, damaged data, full disk): exit code 1. A message is one line:
/// control characters in it, which come from names and contents of files, are shown as \xNN.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message);
  virtual int exit_code() const { return 1; }
};

/// A wrong command line or configuration: exit code 2. Nothing has been written when it is thrown.
class UsageError : public Error {
 public:
  explicit UsageError(const std::string& message) : Error(message) {}
  int exit_code() const override { return 2; }
};

template <class... Args>
[[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args) {
  throw Error(fmt::format(format, std::forward<Args>(args)...));
}

template <class... Args>
[[noreturn]] void fail_usage(fmt::format_string<Args...> format, Args&&... args) {
  throw UsageError(fmt::format(format, std::forward<Args>(args)...));
}

/// The candidate nearest to `word` by edit distance, or "" when none is near enough to be what was meant.
std::string nearest_word(const std::string& word, const std::vector<std::string>& candidates);

}  // namespace ld
