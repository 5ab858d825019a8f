#include "models/history.h"

#include "frame/schema.h"
#include "models/network_numbers.h"
#include "ops/expect_tensor.h"
#include "ops/warp.h"

namespace ld {

using torch::Tensor;

namespace {

constexpr int64_t kCompared = 3, kChange = 1;  // r, s, 1 / n; the place of s
constexpr int64_t kSurface = 4;
constexpr int64_t kTold = 3;  // channels of the light that tell how much has changed

/// Channels of a feature, [B, S, C, H, W], or zeros.
Tensor channels_of(const Tensor& features, const NetworkConfig& config, const char* name) {
  const int64_t first = first_channel(config.features, name), count = find_feature(name).channels;
  if (first >= 0) return features.narrow(2, first, count);
  std::vector<int64_t> sizes = features.sizes().vec();
  sizes[2] = count;
  return at::zeros(sizes, features.options());
}

/// Of the encoding "squash" (frame/encoding.h), infinite where nothing finite is encoded so.
Tensor decoded_flow(const Tensor& encoded) {
  const Tensor room = 1 - encoded.abs();
  return (find_feature("flow").scale * encoded / room).masked_fill(room.le(0), kInfinity);
}

/// [B, C, H, W] of the state; zeros where it has none.
Tensor recalled(const NetworkState& state, const char* name, const Tensor& like, int64_t channels) {
  const std::vector<int64_t> sizes = {like.size(0), channels, like.size(2), like.size(3)};
  const auto found = state.find(name);
  if (found == state.end()) return at::zeros(sizes, like.options());
  expect_tensor("network: state", "[B, C, H, W] of the frame before", found->second,
                {sizes[0], sizes[1], sizes[2], sizes[3]}, like.scalar_type());
  return found->second;
}

/// [r, s, 1 / n] where `known` is 1, else zeros.
Tensor compared(const Tensor& now, const Tensor& past, const Tensor& frames, const Tensor& known) {
  const torch::NoGradGuard no_gradient;
  const Tensor f = now.narrow(1, 0, kTold).clamp_max(kLargestCompared),
               h = past.narrow(1, 0, kTold).clamp_max(kLargestCompared);
  const Tensor difference = known * (h - f), sum = known * (h + f);
  constexpr int kSide = 2 * kComparedRadius + 1;
  const auto over_neighbourhood = [](const Tensor& t) {
    return at::avg_pool2d(t, kSide, 1, kComparedRadius, /*ceil_mode=*/false, /*count_include_pad=*/true,
                          /*divisor_override=*/1);
  };
  const auto relative = [](const Tensor& d, const Tensor& t) {
    return (d.abs() / t.masked_fill(t.eq(0), 1)).mean(1, /*keepdim=*/true);
  };
  return known * at::cat({relative(difference, sum),
                          relative(over_neighbourhood(difference), over_neighbourhood(sum)), 1 / frames},
                         1);
}

/// t of models/history.h, [B, 1, H, W].
Tensor believed(const Tensor& now, const Tensor& past) {
  const torch::NoGradGuard no_gradient;
  const auto sum = [](const Tensor& light) {
    return light.narrow(1, 0, kTold).clamp_max(kLargestCompared).sum(1, /*keepdim=*/true);
  };
  const Tensor h = sum(past);
  return (kBrightestHistory * sum(now) / h.masked_fill(h.eq(0), 1)).clamp_max(1).masked_fill(h.eq(0), 1);
}

}  // namespace

PixelSurfaces pixel_surfaces(const NetworkInput& input, const NetworkConfig& config) {
  const torch::NoGradGuard no_gradient;
  const Tensor drawn = input.valid.ne(0), depth = channels_of(input.features, config, "depth");
  const Tensor order = std::get<1>(at::sort(depth.masked_fill(drawn.logical_not(), kInfinity),
                                            /*stable=*/true, /*dim=*/1, /*descending=*/false));
  const Tensor count = drawn.sum(1, /*keepdim=*/true);
  const Tensor median = order.gather(1, at::floor_divide(count - 1, 2).clamp_min(0));  // [B, 1, 1, H, W]
  const auto of_median = [&](const Tensor& values) {
    std::vector<int64_t> sizes = values.sizes().vec();
    sizes[1] = 1;
    return values.gather(1, median.expand(sizes)).squeeze(1);
  };
  const Tensor none = count.squeeze(1).eq(0);
  const Tensor flow = decoded_flow(of_median(channels_of(input.features, config, "flow"))),
               surface =
                   at::cat({of_median(depth), of_median(channels_of(input.features, config, "normal"))}, 1);
  return {flow.masked_fill(none, kInfinity), surface.masked_fill(none, 0),
          none.logical_not().to(surface.scalar_type())};
}

History::History(const NetworkConfig& config) {
  std::vector<int64_t> widths = config.history;
  widths.insert(widths.begin(), kCompared + config.unet.context);
  widths.push_back(1);
  gate_ = register_module("gate", std::make_shared<FullyConnected>(widths, LastLayer::linear));
}

Tensor History::remembered(const Tensor& light, const Tensor& context, const NetworkInput& input,
                           const NetworkConfig& config, NetworkState& state) const {
  const PixelSurfaces now = pixel_surfaces(input, config);
  const int64_t channels = light.size(1);
  const Tensor left =
      at::cat({recalled(state, "light", light, channels), recalled(state, "frames", light, 1)}, 1);
  // Warping is the CPU's (ops/warp.h).
  const Warped past = warp(left.cpu(), now.flow.cpu(), left.narrow(1, channels, 1).cpu(),
                           {now.surface.cpu(), recalled(state, "surface", light, kSurface).cpu()});
  const Tensor known = past.valid.to(light.device()), values = past.values.to(light.device()),
               history = values.narrow(1, 0, channels),
               frames = values.narrow(1, channels, 1) + (1 - known);  // 1 where there is no history

  const Tensor seen = compared(light, history, frames, known);
  const Tensor logit = with_bounded_gradient(gate_->forward(seen.unsqueeze(1), context).squeeze(1));
  const Tensor k = known * at::sigmoid(logit + frames.log());
  const Tensor result = light + k * (believed(light, history) * history - light);
  const Tensor count = frames / ((1 - k).square() * frames + k.square());
  state = {
      {"light", result}, {"frames", now.drawn * count.clamp_max(kLongestHistory)}, {"surface", now.surface}};
  return result;
}

void History::initialise() {
  const torch::NoGradGuard no_gradient;
  const FullyConnectedWeights& layers = gate_->weights();
  // The first unit of each hidden layer hands s on, which is at least 0; the others begin as they are.
  int64_t handed_on = kChange;
  for (size_t i = 0; i + 1 < layers.weights.size(); ++i) {
    Tensor unit = layers.weights[i][0];
    unit.zero_();
    unit[handed_on] = 1;
    handed_on = 0;
  }
  Tensor weights = layers.weights.back(), bias = layers.biases.back();
  weights.zero_();
  weights[0][handed_on] = -kInitialChange;
  bias.fill_(kInitialHistory);
}

}  // namespace ld
