// The names of the training losses, for those who check a configuration without LibTorch.
#pragma once

#include <string>
#include <vector>

namespace ld {

/// What make_loss() (losses/loss.h) knows, in alphabetical order.
inline const std::vector<std::string>& loss_names() {
  static const std::vector<std::string> names = {
#define LD_LOSS(name, function) name,
#include "losses/losses.def"
#undef LD_LOSS
  };
  return names;
}

}  // namespace ld
