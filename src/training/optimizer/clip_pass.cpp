#include "training/optimizer/clip_pass.h"

#include <vector>

namespace ld {

using torch::Tensor;

NetworkInput frame_of_clips(const NetworkInput& input, int64_t clip, int64_t f) {
  const auto frame = [&](const Tensor& folded) {
    return folded.unflatten(0, {-1, clip}).select(1, f).contiguous();
  };
  return {frame(input.features), frame(input.radiance), frame(input.valid)};
}

Tensor denoise_clips(Network& network, NetworkInput input, int64_t clip, int64_t truncation) {
  if (!network.remembers()) return network.forward(std::move(input));
  NetworkState state;
  std::vector<Tensor> pictures;
  for (int64_t f = 0; f < clip; ++f) {
    if (truncation > 0 && f > 0 && f % truncation == 0)
      for (auto& [name, tensor] : state) tensor = tensor.detach();
    pictures.push_back(network.forward(frame_of_clips(input, clip, f), state));
  }
  return at::stack(pictures, 1).flatten(0, 1);
}

}  // namespace ld
