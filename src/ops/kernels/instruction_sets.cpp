#include "ops/kernels/instruction_sets.h"

#include <fmt/ranges.h>
#include <hwy/highway.h>
#include <hwy/targets.h>

#include <algorithm>

#include "core/error.h"

namespace ld {
namespace {

std::vector<int64_t> targets() {
  std::vector<int64_t> found;
  for (int64_t bits = hwy::SupportedTargets() & HWY_TARGETS; bits != 0; bits &= bits - 1)
    found.push_back(bits & -bits);  // better ones have lower bits
  return found;
}

}  // namespace

std::vector<std::string> instruction_sets() {
  std::vector<std::string> names;
  for (const int64_t target : targets()) names.emplace_back(hwy::TargetName(target));
  return names;
}

void use_instruction_set(const std::string& name) {
  hwy::SetSupportedTargetsForTest(0);  // all that the processor has
  if (!name.empty()) {
    const auto found = targets();
    const auto it =
        std::find_if(found.begin(), found.end(), [&](int64_t t) { return name == hwy::TargetName(t); });
    if (it == found.end())
      fail("no instruction set '{}' on this processor, expected one of {}", name,
           fmt::join(instruction_sets(), ", "));
    hwy::SetSupportedTargetsForTest(*it);
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace ld
