#include "core/module.h"

#include <gtest/gtest.h>

#include "tests/support/expect_error.h"

namespace ld {
namespace {

TEST(Module, OneThatIsMissingIsAnErrorThatSaysWhereItBelongsAndWhatToDo) {
  EXPECT_ERROR(
      load_module("ld_nothing", "does nothing", "do without"),
      "/lib/layer_denoiser/libld_nothing.so, which does nothing: no such file; expected it where the "
      "program was built or installed: do without");
}

}  // namespace
}  // namespace ld
