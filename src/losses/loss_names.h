// The names of the training losses, for those who check a configuration without LibTorch.
#pragma once

#include <string>
#include <vector>

namespace ld {

/// What make_loss() (losses/loss.h) knows, in alphabetical order.
inline const std::vector<std::string>& loss_names() {
  static const std::vector<std::string> names = {"l1",          "l2_tonemapped",   "l2_tonemapped_linear",
                                                 "relative_l2", "relmse",          "smape",
                                                 "smape_l2",    "smape_multiscale"};
  return names;
}

}  // namespace ld
