#include "core/error.h"

#include <gtest/gtest.h>

namespace ld {
namespace {

TEST(ErrorMessage, IsOneLineWhateverAFileBrings) {
  const std::string name = "a\nb\x1b[2Jc\td\x7f";
  EXPECT_STREQ(Error(name).what(), "a\\x0ab\\x1b[2Jc\\x09d\\x7f");
  try {
    fail_usage("{}: unknown", name);
  } catch (const UsageError& error) {
    EXPECT_STREQ(error.what(), "a\\x0ab\\x1b[2Jc\\x09d\\x7f: unknown");
    EXPECT_EQ(error.exit_code(), 2);
  }
}

TEST(ErrorMessage, LongMessagesAndOtherAlphabetsStayWhole) {
  const std::string text = std::string(5000, 'x') + "\u00fc";
  EXPECT_EQ(Error(text).what(), text);
}

}  // namespace
}  // namespace ld
