#include "core/process/process_memory.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/sanitized.h"

namespace ld {
namespace {

TEST(ProcessMemory, ThePeakIsThatSinceItWasReset) {
  if (kAddressSanitizer) GTEST_SKIP() << "the sanitizer keeps what is freed";
  constexpr int64_t kBytes = int64_t(64) << 20, kSlack = int64_t(8) << 20;
  const int64_t before = resident_bytes();
  ASSERT_GT(before, 0);
  {
    const std::vector<char> written(kBytes, 1);
    EXPECT_NEAR(double(resident_bytes() - before), double(kBytes), double(kSlack));
  }
  EXPECT_GE(peak_resident_bytes(), before + kBytes - kSlack);
  reset_peak_resident();
  EXPECT_LT(peak_resident_bytes(), before + kSlack);
  EXPECT_GT(available_bytes(), 0);
}

}  // namespace
}  // namespace ld
