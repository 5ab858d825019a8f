#include "tests/support/scalar_reference.h"

#include <algorithm>
#include <cmath>

namespace ld::reference {
namespace {

double leaky(double x) {
  return x > 0 ? x : 0.01 * x;
}

Grid convolve(const Grid& in, const Parameters& parameters, const std::string& name, bool activate) {
  const Parameter &weight = parameters.at(name + ".weight"), &bias = parameters.at(name + ".bias");
  Grid out(in.b, 1, weight.shape[0], in.h, in.w);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    for (int64_t o = 0; o < out.c; ++o) {
      double sum = bias.values[static_cast<size_t>(o)];
      for (int64_t i = 0; i < in.c; ++i)
        for (int64_t dy = 0; dy < 3; ++dy)
          for (int64_t dx = 0; dx < 3; ++dx) {
            const int64_t yy = y + dy - 1, xx = x + dx - 1;
            if (yy < 0 || yy >= in.h || xx < 0 || xx >= in.w) continue;
            sum +=
                weight.values[static_cast<size_t>(((o * in.c + i) * 3 + dy) * 3 + dx)] * in(b, 0, i, yy, xx);
          }
      out(b, 0, o, y, x) = activate ? leaky(sum) : sum;
    }
  });
  return out;
}

/// Convolutions of a block are the even children of its sequence, activations the odd ones.
Grid block(Grid x, const Parameters& parameters, const std::string& name, int64_t count) {
  for (int64_t i = 0; i < count; ++i) x = convolve(x, parameters, name + "." + std::to_string(2 * i), true);
  return x;
}

Grid pool(const Grid& in) {
  Grid out(in.b, 1, in.c, in.h / 2, in.w / 2);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    for (int64_t c = 0; c < in.c; ++c)
      out(b, 0, c, y, x) = std::max({in(b, 0, c, 2 * y, 2 * x), in(b, 0, c, 2 * y, 2 * x + 1),
                                     in(b, 0, c, 2 * y + 1, 2 * x), in(b, 0, c, 2 * y + 1, 2 * x + 1)});
  });
  return out;
}

Grid concatenate(const Grid& first, const Grid& second) {
  Grid out(first.b, 1, first.c + second.c, first.h, first.w);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    for (int64_t c = 0; c < out.c; ++c)
      out(b, 0, c, y, x) = c < first.c ? first(b, 0, c, y, x) : second(b, 0, c - first.c, y, x);
  });
  return out;
}

}  // namespace

Grid upsample(const Grid& in, int64_t factor, bool bilinear) {
  Grid out(in.b, 1, in.c, factor * in.h, factor * in.w);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    const double v = std::clamp((double(y) + 0.5) / double(factor) - 0.5, 0.0, double(in.h - 1));
    const double u = std::clamp((double(x) + 0.5) / double(factor) - 0.5, 0.0, double(in.w - 1));
    const auto y0 = int64_t(v), x0 = int64_t(u);
    const int64_t y1 = std::min(y0 + 1, in.h - 1), x1 = std::min(x0 + 1, in.w - 1);
    const double fy = v - double(y0), fx = u - double(x0);
    for (int64_t c = 0; c < in.c; ++c)
      out(b, 0, c, y, x) = bilinear ? (1 - fy) * ((1 - fx) * in(b, 0, c, y0, x0) + fx * in(b, 0, c, y0, x1)) +
                                          fy * ((1 - fx) * in(b, 0, c, y1, x0) + fx * in(b, 0, c, y1, x1))
                                    : in(b, 0, c, y / factor, x / factor);
  });
  return out;
}

Grid resize(const Grid& in, int64_t h, int64_t w) {
  Grid out(in.b, 1, in.c, h, w);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    for (int64_t c = 0; c < in.c; ++c)
      out(b, 0, c, y, x) = in(b, 0, c, std::min(y, in.h - 1), std::min(x, in.w - 1));
  });
  return out;
}

Grid fully_connected(const Grid& x, const Grid& shared, const Parameters& parameters,
                     const std::string& prefix, bool activate_last) {
  size_t layers = 0;
  while (parameters.count(prefix + std::to_string(layers) + ".weight") > 0) ++layers;
  Grid out(x.b, x.s, parameters.at(prefix + std::to_string(layers - 1) + ".weight").shape[0], x.h, x.w);
  each(out, [&](int64_t b, int64_t s, int64_t y, int64_t px) {
    std::vector<double> a;
    for (int64_t c = 0; c < x.c; ++c) a.push_back(x(b, s, c, y, px));
    for (int64_t c = 0; c < shared.c; ++c) a.push_back(shared(b, 0, c, y, px));
    for (size_t layer = 0; layer < layers; ++layer) {
      const Parameter& weight = parameters.at(prefix + std::to_string(layer) + ".weight");
      std::vector<double> next = parameters.at(prefix + std::to_string(layer) + ".bias").values;
      for (size_t o = 0; o < next.size(); ++o) {
        for (size_t i = 0; i < a.size(); ++i) next[o] += weight.values[o * a.size() + i] * a[i];
        if (layer + 1 < layers || activate_last) next[o] = leaky(next[o]);
      }
      a = next;
    }
    for (int64_t c = 0; c < out.c; ++c) out(b, s, c, y, px) = a[static_cast<size_t>(c)];
  });
  return out;
}

Grid masked_mean(const Grid& values, const Grid& valid) {
  Grid out(values.b, 1, values.c, values.h, values.w);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    double count = 0;
    for (int64_t s = 0; s < values.s; ++s) count += valid(b, s, 0, y, x) != 0 ? 1 : 0;
    for (int64_t c = 0; c < values.c; ++c)
      for (int64_t s = 0; s < values.s; ++s)
        if (valid(b, s, 0, y, x) != 0) out(b, 0, c, y, x) += values(b, s, c, y, x) / count;
  });
  return out;
}

Layers partition(const Grid& logits, const Grid& valid, const Grid& radiance, const Grid& embedding) {
  const int64_t layers = logits.c;
  Layers out;
  out.weight = out.occupancy = Grid(logits.b, layers, 1, logits.h, logits.w);
  out.radiance = Grid(logits.b, layers, radiance.c, logits.h, logits.w);
  out.embedding = Grid(logits.b, layers, embedding.c, logits.h, logits.w);
  each(logits, [&](int64_t b, int64_t s, int64_t y, int64_t x) {
    if (valid(b, s, 0, y, x) == 0) return;
    double count = 0, sum = 0;
    for (int64_t k = 0; k < logits.s; ++k) count += valid(b, k, 0, y, x) != 0 ? 1 : 0;
    for (int64_t l = 0; l < layers; ++l) sum += std::exp(logits(b, s, l, y, x));
    for (int64_t l = 0; l < layers; ++l) {
      const double w = std::exp(logits(b, s, l, y, x)) / sum / count;
      out.weight(b, l, 0, y, x) += w;
      for (int64_t j = 0; j <= l; ++j) out.occupancy(b, j, 0, y, x) += w;
      for (int64_t c = 0; c < radiance.c; ++c) out.radiance(b, l, c, y, x) += w * radiance(b, s, c, y, x);
      for (int64_t c = 0; c < embedding.c; ++c) out.embedding(b, l, c, y, x) += w * embedding(b, s, c, y, x);
    }
  });
  return out;
}

Grid splat(const Grid& logits, const Grid& values) {
  const auto size = int64_t(std::lround(std::sqrt(double(logits.c))));
  Grid out(values.b, values.s, values.c, values.h, values.w);
  each(logits, [&](int64_t b, int64_t l, int64_t y, int64_t x) {
    double largest = logits(b, 0, 0, y, x);
    for (int64_t k = 0; k < logits.s; ++k)
      for (int64_t t = 0; t < logits.c; ++t) largest = std::max(largest, logits(b, k, t, y, x));
    for (int64_t t = 0; t < logits.c; ++t) {
      const int64_t yy = y + t / size - size / 2, xx = x + t % size - size / 2;
      if (yy < 0 || yy >= values.h || xx < 0 || xx >= values.w) continue;
      const double weight = std::exp(logits(b, l, t, y, x) - largest);
      for (int64_t c = 0; c < values.c; ++c) out(b, l, c, yy, xx) += weight * values(b, l, c, y, x);
    }
  });
  return out;
}

Grid composite(const Grid& filtered_radiance, const Grid& filtered_weight, const Grid& filtered_occupancy) {
  const Grid &r = filtered_radiance, &w = filtered_weight, &n = filtered_occupancy;
  Grid out(r.b, 1, r.c, r.h, r.w);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    double visible = 1;
    for (int64_t l = 0; l < r.s && n(b, l, 0, y, x) > 0; ++l) {
      for (int64_t c = 0; c < r.c; ++c) out(b, 0, c, y, x) += visible * r(b, l, c, y, x) / n(b, l, 0, y, x);
      visible *= 1 - w(b, l, 0, y, x) / n(b, l, 0, y, x);
    }
  });
  return out;
}

std::vector<Grid> unet(const Grid& input, const Parameters& parameters, const UNetLayout& layout) {
  const int64_t multiple = int64_t(1) << layout.encoder.size();
  Grid x = resize(input, (input.h + multiple - 1) / multiple * multiple,
                  (input.w + multiple - 1) / multiple * multiple);
  std::vector<Grid> skips, features;
  const auto keep = [&](const Grid& picture, size_t halvings) {
    const int64_t scale = int64_t(1) << halvings;
    features.insert(features.begin(),
                    resize(picture, (input.h + scale - 1) / scale, (input.w + scale - 1) / scale));
  };
  for (size_t i = 0; i < layout.encoder.size(); ++i) {
    skips.push_back(x);
    x = pool(block(x, parameters, "unet.encoder" + std::to_string(i), layout.encoder[i]));
  }
  x = block(x, parameters, "unet.bottleneck", layout.bottleneck);
  for (size_t i = 0; i < layout.decoder.size(); ++i) {
    keep(x, layout.decoder.size() - i);
    x = concatenate(upsample(x, 2, layout.bilinear), skips[skips.size() - 1 - i]);
    x = block(x, parameters, "unet.decoder" + std::to_string(i), layout.decoder[i]);
  }
  keep(convolve(x, parameters, "unet.context", false), 0);
  return features;
}

}  // namespace ld::reference
