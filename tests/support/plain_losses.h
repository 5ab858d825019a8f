// Which losses can be checked by finite differences.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "losses/loss.h"

namespace ld {

/// Those that hold a part of their formula fixed: their gradient is not the derivative of their value, which
/// is their point. tests/losses compares it with its formula.
inline std::vector<std::string> losses_with_held_parts() {
  return {"l2_tonemapped_linear", "relative_l2"};
}

/// All others.
inline std::vector<std::string> plain_losses() {
  std::vector<std::string> names = loss_names();
  for (const std::string& held : losses_with_held_parts())
    names.erase(std::remove(names.begin(), names.end(), held), names.end());
  return names;
}

}  // namespace ld
