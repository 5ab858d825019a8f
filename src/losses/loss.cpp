#include "losses/loss.h"

#include <fmt/ranges.h>

#include <map>

#include "core/error.h"
#include "losses/l1.h"
#include "losses/l2_tonemapped.h"
#include "losses/l2_tonemapped_linear.h"
#include "losses/relative_l2.h"
#include "losses/relmse_loss.h"
#include "losses/smape_l2.h"
#include "losses/smape_loss.h"
#include "losses/smape_multiscale.h"

namespace ld {
namespace {

/// A new loss is one line here, its name in loss_names.h and one file beside this one.
const std::map<std::string, Loss>& registry() {
  static const std::map<std::string, Loss> losses = {
      {"l1", l1},
      {"l2_tonemapped", l2_tonemapped},
      {"l2_tonemapped_linear", l2_tonemapped_linear},
      {"relative_l2", relative_l2},
      {"relmse", relmse_loss},
      {"smape", smape_loss},
      {"smape_l2", smape_l2_loss},
      {"smape_multiscale", smape_multiscale_loss},
  };
  return losses;
}

}  // namespace

Loss make_loss(const std::string& name) {
  const auto found = registry().find(name);
  if (found == registry().end()) {
    const std::string nearest = nearest_word(name, loss_names());
    fail_usage("unknown loss '{}'; {}choose from {}", name,
               nearest.empty() ? "" : fmt::format("did you mean '{}'? ", nearest),
               fmt::join(loss_names(), ", "));
  }
  return [name, loss = found->second](const torch::Tensor& denoised, const torch::Tensor& reference) {
    if (denoised.sizes() != reference.sizes() || denoised.scalar_type() != reference.scalar_type())
      fail("loss {}: the denoised image is {} [{}] and the reference {} [{}], expected the same", name,
           toString(denoised.scalar_type()), fmt::join(denoised.sizes(), ", "),
           toString(reference.scalar_type()), fmt::join(reference.sizes(), ", "));
    return loss(denoised, reference);
  };
}

}  // namespace ld
