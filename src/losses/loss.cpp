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

const std::map<std::string, Loss>& registry() {
  static const std::map<std::string, Loss> losses = {
#define LD_LOSS(name, function) {name, function},
#include "losses/losses.def"
#undef LD_LOSS
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
    return loss(denoised, reference.to(denoised.device()));
  };
}

}  // namespace ld
