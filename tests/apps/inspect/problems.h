// What ld_inspect finds wrong with a file or folder, for the tests.
#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "apps/inspect/inspect.h"

namespace ld {

/// The problems as one text.
inline std::string problems(const std::filesystem::path& path, bool verify = false) {
  InspectOptions options;
  options.verify = verify;
  std::string text;
  for (const std::string& problem : inspect(path, options).problems) text += problem + "\n";
  return text;
}

inline void expect_problem(const std::filesystem::path& path, const std::string& part, bool verify = false) {
  const std::string found = problems(path, verify);
  EXPECT_NE(found.find(part), std::string::npos) << "expected '" << part << "' in: " << found;
}

}  // namespace ld
