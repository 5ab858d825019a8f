#include "training/optimizer/adam_state.h"

#include <torch/version.h>

#include <memory>

#include "core/error.h"

namespace ld {
namespace {

auto state_key(const torch::Tensor& parameter) {
#if TORCH_VERSION_MAJOR >= 2
  return static_cast<void*>(parameter.unsafeGetTensorImpl());
#else
  return c10::guts::to_string(parameter.unsafeGetTensorImpl());
#endif
}

struct Moments {
  torch::Tensor mean, square;
};

void set_state(torch::optim::Adam& optimizer, const torch::Tensor& parameter, const Moments& moments,
               int64_t steps) {
  auto state = std::make_unique<torch::optim::AdamParamState>();
  state->step(steps);
  state->exp_avg(moments.mean.to(parameter.device()));
  state->exp_avg_sq(moments.square.to(parameter.device()));
  optimizer.state()[state_key(parameter)] = std::move(state);
}

}  // namespace

NamedTensors adam_state(torch::optim::Adam& optimizer, const Network& network) {
  NamedTensors tensors;
  for (const auto& parameter : network.named_parameters()) {
    const auto found = optimizer.state().find(state_key(parameter.value()));
    if (found == optimizer.state().end()) continue;
    const auto& state = static_cast<const torch::optim::AdamParamState&>(*found->second);
    tensors.emplace_back("exp_avg." + parameter.key(), state.exp_avg());
    tensors.emplace_back("exp_avg_sq." + parameter.key(), state.exp_avg_sq());
  }
  return tensors;
}

void set_adam_state(torch::optim::Adam& optimizer, const Network& network, const SafetensorsFile& file,
                    int64_t steps) {
  std::vector<std::pair<torch::Tensor, Moments>> states;
  for (const auto& parameter : network.named_parameters()) {
    states.emplace_back(parameter.value(),
                        Moments{read_tensor(file.tensor("exp_avg." + parameter.key())),
                                read_tensor(file.tensor("exp_avg_sq." + parameter.key()))});
    const Moments& moments = states.back().second;
    if (moments.mean.sizes() != parameter.value().sizes() ||
        moments.square.sizes() != parameter.value().sizes())
      fail(
          "{}: the state of '{}' has another shape than the parameter; the checkpoint is damaged, use an "
          "earlier one",
          file.path().string(), parameter.key());
  }
  for (const auto& [parameter, moments] : states) set_state(optimizer, parameter, moments, steps);
}

void make_adam_state(torch::optim::Adam& optimizer, const Network& network, int64_t steps) {
  for (const torch::Tensor& parameter : network.parameters())
    set_state(optimizer, parameter,
              {torch::zeros_like(parameter.detach()), torch::zeros_like(parameter.detach())}, steps);
}

}  // namespace ld
