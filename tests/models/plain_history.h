// The equations of models/history.h, a pixel at a time, in double.
#pragma once

#include <torch/torch.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <utility>
#include <vector>

#include "frame/schema.h"
#include "models/network.h"

namespace ld {

using torch::Tensor;

struct PlainState {
  Tensor light, frames, surface;
};

inline bool plain_same(const Tensor& a, const Tensor& b) {
  const auto value = [](const Tensor& t, int64_t i) { return t[i].item<double>(); };
  double cosine = 0, aa = 0, bb = 0;
  for (int64_t i = 1; i < 4; ++i) {
    cosine += value(a, i) * value(b, i);
    aa += value(a, i) * value(a, i);
    bb += value(b, i) * value(b, i);
  }
  const double da = value(a, 0) * (1 - value(b, 0)), db = value(b, 0) * (1 - value(a, 0));
  return da <= 1.25 * db && db <= 1.25 * da && cosine >= 0.5 * std::sqrt(aa) * std::sqrt(bb);
}

/// The sample that stands for pixel (x, y), or -1.
inline int64_t plain_representative(const NetworkInput& input, const NetworkConfig& config, int64_t y,
                                    int64_t x) {
  std::vector<std::pair<double, int64_t>> depths;
  for (int64_t s = 0; s < input.valid.size(1); ++s)
    if (input.valid[0][s][0][y][x].item<double>() != 0)
      depths.emplace_back(input.features[0][s][first_channel(config.features, "depth")][y][x].item<double>(),
                          s);
  std::sort(depths.begin(), depths.end());
  return depths.empty() ? -1 : depths[(depths.size() - 1) / 2].second;
}

/// `logits`: what the gate makes of what it sees.
inline Tensor plain_remembered(const Tensor& light, const NetworkInput& input, const NetworkConfig& config,
                               const std::function<Tensor(const Tensor&)>& logits, PlainState& state) {
  const int64_t channels = light.size(1), h = light.size(2), w = light.size(3);
  Tensor past = torch::zeros_like(light), frames = torch::zeros({1, 1, h, w}, torch::kFloat64),
         surface = torch::zeros({1, 4, h, w}, torch::kFloat64), drawn = torch::zeros_like(frames);
  const auto at = [](Tensor& t, int64_t c, int64_t y, int64_t x) -> double& {
    return t.data_ptr<double>()[(c * t.size(2) + y) * t.size(3) + x];
  };
  for (int64_t y = 0; y < h; ++y)
    for (int64_t x = 0; x < w; ++x) {
      const int64_t s = plain_representative(input, config, y, x);
      if (s < 0) continue;
      const auto feature = [&](const char* name, int64_t c) {
        return input.features[0][s][first_channel(config.features, name) + c][y][x].item<double>();
      };
      at(drawn, 0, y, x) = 1;
      at(surface, 0, y, x) = feature("depth", 0);
      for (int64_t c = 0; c < 3; ++c) at(surface, 1 + c, y, x) = feature("normal", c);
      if (!state.light.defined()) continue;
      const double ex = feature("flow", 0), ey = feature("flow", 1);
      const double px = double(x) + 16 * ex / (1 - std::abs(ex)),
                   py = double(y) + 16 * ey / (1 - std::abs(ey));
      double sum = 0;
      for (int64_t v = 0; v < h; ++v)
        for (int64_t u = 0; u < w; ++u) {
          const double weight =
              std::max(0.0, 1 - std::abs(px - double(u))) * std::max(0.0, 1 - std::abs(py - double(v)));
          if (weight == 0 || at(state.frames, 0, v, u) == 0 ||
              !plain_same(surface.select(3, x).select(2, y)[0], state.surface.select(3, u).select(2, v)[0]))
            continue;
          sum += weight;
          for (int64_t c = 0; c < channels; ++c) at(past, c, y, x) += weight * at(state.light, c, v, u);
          at(frames, 0, y, x) += weight * at(state.frames, 0, v, u);
        }
      for (int64_t c = 0; c < channels; ++c) at(past, c, y, x) *= sum < 0.01 ? 0 : 1 / sum;
      at(frames, 0, y, x) *= sum < 0.01 ? 0 : 1 / sum;
    }
  Tensor seen = torch::zeros({1, 3, h, w}, torch::kFloat64), now = light.clone();
  for (int64_t y = 0; y < h; ++y)
    for (int64_t x = 0; x < w; ++x) {
      if (at(frames, 0, y, x) == 0) continue;
      at(seen, 2, y, x) = 1 / at(frames, 0, y, x);
      for (int64_t c = 0; c < 3; ++c) {
        const double f = at(now, c, y, x), p = at(past, c, y, x);
        at(seen, 0, y, x) += f + p == 0 ? 0 : std::abs(p - f) / (f + p) / 3;
        double difference = 0, sum = 0;
        for (int64_t v = std::max<int64_t>(y - 2, 0); v <= std::min(y + 2, h - 1); ++v)
          for (int64_t u = std::max<int64_t>(x - 2, 0); u <= std::min(x + 2, w - 1); ++u) {
            if (at(frames, 0, v, u) == 0) continue;
            difference += at(past, c, v, u) - at(now, c, v, u);
            sum += at(past, c, v, u) + at(now, c, v, u);
          }
        at(seen, 1, y, x) += sum == 0 ? 0 : std::abs(difference) / sum / 3;
      }
    }
  Tensor g = logits(seen).contiguous(), result = light.clone(), left = torch::zeros_like(frames);
  for (int64_t y = 0; y < h; ++y)
    for (int64_t x = 0; x < w; ++x) {
      const double n = at(frames, 0, y, x), e = std::exp(at(g, 0, y, x));
      const double k = n * e / (1 + n * e);
      double f = 0, p = 0;
      for (int64_t c = 0; c < 3; ++c) {
        f += at(now, c, y, x);
        p += at(past, c, y, x);
      }
      const double t = p > 2 * f ? 2 * f / p : 1;
      for (int64_t c = 0; c < channels; ++c)
        at(result, c, y, x) = (1 - k) * at(now, c, y, x) + k * t * at(past, c, y, x);
      const double count = n == 0 ? 1 : std::min(1 / ((1 - k) * (1 - k) + k * k / n), 32.0);
      at(left, 0, y, x) = at(drawn, 0, y, x) * count;
    }
  state = {result, left, surface};
  return result;
}

}  // namespace ld
