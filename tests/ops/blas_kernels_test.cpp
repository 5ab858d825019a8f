#include "ops/blas_kernels.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

namespace ld {
namespace {

TEST(BlasKernels, OldKernelsOnANewProcessorAreReplaced) {
  EXPECT_EQ(better_blas_kernels("Prescott", true, true), "SkylakeX");
  EXPECT_EQ(better_blas_kernels("Prescott", true, false), "Haswell");
  EXPECT_EQ(better_blas_kernels("Sandybridge", true, false), "Haswell");
}

TEST(BlasKernels, FittingKernelsStay) {
  EXPECT_EQ(better_blas_kernels("Prescott", false, false), "");
  for (const char* kernels : {"Haswell", "Zen", "SkylakeX", "Cooperlake", "SapphireRapids", "ARMV8", ""})
    EXPECT_EQ(better_blas_kernels(kernels, true, true), "") << kernels;
}

TEST(BlasKernels, AProgramStartsAgainWithKernelsThatFitTheProcessor) {
  if (std::getenv("LD_TEST_CHILD") != nullptr) {  // the process that this test starts below
    choose_blas_kernels();
    EXPECT_EQ(better_blas_kernels(blas_kernels(), __builtin_cpu_supports("avx2") != 0, false), "");
    EXPECT_STREQ(std::getenv("LD_TEST_CHILD"), "kept over the restart");
    return;
  }
  const std::string self = std::filesystem::read_symlink("/proc/self/exe").string();
  const std::string command = "env -u OPENBLAS_CORETYPE LD_TEST_CHILD='kept over the restart' '" + self +
                              "' --gtest_filter='BlasKernels.AProgramStartsAgain*' >/dev/null";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

}  // namespace
}  // namespace ld
