#include "ops/kernels/tone_map_row.h"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "core/tone_map.h"
#include "ops/kernels/instruction_sets.h"

namespace ld {
namespace {

TEST(ToneMapRow, IsTheToneMapOnEveryInstructionSet) {
  std::vector<float> x = {0.0F,       -0.0F,      -1.0F, -3e38F,   1e-45F, 1e-38F,
                          0.0031308F, 0.0031357F, 1.0F,  65504.0F, 1e15F,  3e38F};
  for (float value = 1e-7F; value < 1e9F; value *= 1.01F) x.push_back(value);
  for (const std::string& set : instruction_sets()) {
    use_instruction_set(set);
    for (const size_t count : {x.size(), size_t(1), size_t(7)}) {
      std::vector<float> out(count + 1, -7.0F);
      tone_map_row(x.data(), out.data(), int64_t(count));
      for (size_t i = 0; i < count; ++i) {
        const double expected = tone_map(double(x[i]));
        EXPECT_NEAR(out[i], expected, 2e-6 * expected + 1e-37) << set << " at " << x[i];
      }
      EXPECT_EQ(out[count], -7.0F);  // nothing behind the row is touched
    }
    float infinite = std::numeric_limits<float>::infinity();
    tone_map_row(&infinite, &infinite, 1);
    EXPECT_NEAR(infinite, tone_map(double(std::numeric_limits<float>::max())), 1e-5) << set;
  }
  use_instruction_set("");
}

}  // namespace
}  // namespace ld
