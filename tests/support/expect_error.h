// Checks that an expression throws ld::Error with a text that says what it must.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "core/error.h"

namespace ld {

/// The text of the Error that `action` throws; a failure of the test when it throws none.
template <class Action>
std::string error_text(Action action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  ADD_FAILURE() << "expected an Error, none was thrown";
  return "";
}

}  // namespace ld

/// The expression throws an Error whose text contains `part` and is one line.
#define EXPECT_ERROR(expression, part)                                           \
  do {                                                                           \
    const std::string ld_text = ld::error_text([&] { (void)(expression); });     \
    EXPECT_NE(ld_text.find(part), std::string::npos) << "the text: " << ld_text; \
    EXPECT_EQ(ld_text.find('\n'), std::string::npos) << "the text: " << ld_text; \
  } while (false)
