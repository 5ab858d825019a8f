#include "training/optimizer/clip_pass.h"

#include <utility>
#include <vector>

namespace ld {

using torch::Tensor;

namespace {

Compared compare_frame(Network& network, const Batch& batch, int64_t f, NetworkState& state) {
  return network.compare(frame_of_clips(batch.input, batch.clip, f),
                         batch.by_clip(batch.reference).select(1, f), state);
}

/// Of each frame of clips, all frames, clip after clip.
Tensor folded(const std::vector<Tensor>& frames) {
  return at::stack(frames, 1).flatten(0, 1);
}

void cut_gradients(NetworkState& state) {
  for (auto& [name, tensor] : state) tensor = tensor.detach();
}

bool is_cut(int64_t f, int64_t truncation) {
  return f == 0 || (truncation > 0 && f % truncation == 0);
}

/// ClipPassOptions::recompute: forward without activations; the gradient of the loss in what was predicted;
/// then back, a frame at a time, with the gradient in what the frame left from the frame behind it.
double add_gradient_by_frames(Network& network, const Batch& batch, const ClipLoss& loss, double share,
                              int64_t truncation) {
  std::vector<Tensor> predicted, target;
  std::vector<NetworkState> before;
  NetworkState state;
  for (int64_t f = 0; f < batch.clip; ++f) {
    const torch::NoGradGuard no_activations;
    before.push_back(state);
    const Compared compared = compare_frame(network, batch, f, state);
    predicted.push_back(compared.predicted);
    target.push_back(compared.target);
  }
  state.clear();
  const Tensor whole = folded(predicted).set_requires_grad(true);
  const Tensor value = loss(whole, folded(target), batch.clip) * share;
  const Tensor of_predicted = batch.by_clip(torch::autograd::grad({value}, {whole})[0]);

  NetworkState of_after;  // gradients in what a frame leaves
  for (int64_t f = batch.clip - 1; f >= 0; --f) {
    NetworkState left = std::move(before[size_t(f)]);
    for (auto& [name, tensor] : left) tensor = tensor.detach().set_requires_grad(!is_cut(f, truncation));
    NetworkState now = left;
    std::vector<Tensor> outputs = {compare_frame(network, batch, f, now).predicted},
                        gradients = {of_predicted.select(1, f)};
    for (const auto& [name, gradient] : of_after) {
      if (!now.at(name).requires_grad()) continue;
      outputs.push_back(now.at(name));
      gradients.push_back(gradient);
    }
    torch::autograd::backward(outputs, gradients);
    of_after.clear();
    for (const auto& [name, tensor] : left)
      if (tensor.grad().defined()) of_after[name] = tensor.grad();
  }
  return value.item<double>();
}

}  // namespace

NetworkInput frame_of_clips(const NetworkInput& input, int64_t clip, int64_t f) {
  const auto frame = [&](const Tensor& folded) {
    return folded.unflatten(0, {-1, clip}).select(1, f).contiguous();
  };
  return {frame(input.features), frame(input.radiance), frame(input.valid)};
}

Compared compare_clips(Network& network, Batch batch, int64_t truncation) {
  NetworkState state;
  if (!network.remembers()) return network.compare(std::move(batch.input), batch.reference, state);
  std::vector<Tensor> pictures, predicted, target;
  for (int64_t f = 0; f < batch.clip; ++f) {
    if (is_cut(f, truncation)) cut_gradients(state);
    const Compared compared = compare_frame(network, batch, f, state);
    pictures.push_back(compared.picture);
    predicted.push_back(compared.predicted);
    target.push_back(compared.target);
  }
  return {folded(pictures), folded(predicted), folded(target)};
}

double add_gradient(Network& network, Batch batch, const ClipLoss& loss, double share,
                    const ClipPassOptions& options) {
  if (options.recompute && network.remembers())
    return add_gradient_by_frames(network, batch, loss, share, options.truncation);
  const int64_t clip = batch.clip;
  const Compared compared = compare_clips(network, std::move(batch), options.truncation);
  const Tensor value = loss(compared.predicted, compared.target, clip) * share;
  value.backward();
  return value.item<double>();
}

}  // namespace ld
