#include "tests/support/scalar_super_resolution.h"

#include <algorithm>
#include <cmath>

#include "tests/support/scalar_modulation.h"

namespace ld::reference {

Grid drawn(const Grid& valid) {
  Grid out(valid.b, 1, 1, valid.h, valid.w);
  each(valid, [&](int64_t b, int64_t s, int64_t y, int64_t x) {
    if (valid(b, s, 0, y, x) != 0) out(b, 0, 0, y, x) = 1;
  });
  return out;
}

Grid bounded(Grid logits, const NetworkLayout& layout) {
  const double c = layout.logit_bound;
  each(logits, [&](int64_t b, int64_t s, int64_t y, int64_t x) {
    for (int64_t t = 0; t < layout.kernel_size * layout.kernel_size && c > 0; ++t) {
      double& z = logits(b, s, t, y, x);
      z = c * z / (c + std::abs(z));
    }
  });
  return logits;
}

Grid gather(const Grid& logits, const Grid& values, const Grid& given) {
  const auto size = int64_t(std::lround(std::sqrt(double(logits.c))));
  Grid out(values.b, 1, values.c, values.h, values.w);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    double sum = 0;
    for (int64_t t = 0; t < logits.c; ++t) {
      const int64_t yy = y + t / size - size / 2, xx = x + t % size - size / 2;
      if (yy < 0 || yy >= values.h || xx < 0 || xx >= values.w || given(b, 0, 0, yy, xx) == 0) continue;
      const double weight = std::exp(logits(b, 0, t, y, x));
      sum += weight;
      for (int64_t c = 0; c < values.c; ++c) out(b, 0, c, y, x) += weight * values(b, 0, c, yy, xx);
    }
    for (int64_t c = 0; c < values.c && sum > 0; ++c) out(b, 0, c, y, x) /= sum;
  });
  return out;
}

namespace {

/// kernel x kernel taps; pixels beyond the border are those of the border.
Grid edge_convolution(const Grid& in, const Parameters& parameters, const std::string& name) {
  const Parameter &weight = parameters.at(name + ".weight"), &bias = parameters.at(name + ".bias");
  const int64_t outputs = weight.shape[0], inputs = weight.shape[1], kernel = weight.shape[2];
  Grid out(in.b, 1, outputs, in.h, in.w);
  each(in, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    for (int64_t o = 0; o < outputs; ++o) {
      double sum = bias.values[size_t(o)];
      for (int64_t c = 0; c < inputs; ++c)
        for (int64_t t = 0; t < kernel * kernel; ++t) {
          const int64_t yy = std::clamp<int64_t>(y + t / kernel - kernel / 2, 0, in.h - 1),
                        xx = std::clamp<int64_t>(x + t % kernel - kernel / 2, 0, in.w - 1);
          sum += weight.values[size_t((o * inputs + c) * kernel * kernel + t)] * in(b, 0, c, yy, xx);
        }
      out(b, 0, o, y, x) = sum;
    }
  });
  return out;
}

template <class Function>
Grid mapped(Grid g, const Function& function) {
  for (double& value : g.values) value = function(value);
  return g;
}

Grid together(const std::vector<Grid>& parts) {
  int64_t channels = 0;
  for (const Grid& part : parts) channels += part.c;
  Grid out(parts[0].b, 1, channels, parts[0].h, parts[0].w);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    int64_t to = 0;
    for (const Grid& part : parts)
      for (int64_t c = 0; c < part.c; ++c) out(b, 0, to++, y, x) = part(b, 0, c, y, x);
  });
  return out;
}

/// [MH20] eq. 7, and what it takes there.
double shown(double x) {
  const double y = std::log1p(x);
  return y <= 0.0031308 ? 12.92 * y : 1.055 * std::pow(y, 1 / 2.4) - 0.055;
}
double linear(double y) {
  if (y <= 0) return 0;
  return std::min(std::expm1(y <= 0.04045 ? y / 12.92 : std::pow((y + 0.055) / 1.055, 2.4)), 65504.0);
}

}  // namespace

Grid espcn_kpcn(const Samples& samples, const Parameters& parameters, const NetworkLayout& layout) {
  const Grid means = masked_mean(samples.features, samples.valid), given = drawn(samples.valid),
             light = masked_mean(samples.radiance, samples.valid);
  const Grid a = layout.demodulates ? masked_mean(demodulator(samples.features, layout), samples.valid)
                                    : mapped(light, [](double) { return 1.0; });
  const int64_t h = means.h, w = means.w, hh = (h + 1) / 2, hw = (w + 1) / 2, guides = means.c - 3;
  const auto guide = [&](int64_t g) { return g < layout.radiance ? g : g + 3; };
  const auto row = [&](int64_t y) { return std::min(y, h - 1); };
  const auto column = [&](int64_t x) { return std::min(x, w - 1); };

  Grid half(means.b, 1, 3, hh, hw), half_a = half, known(means.b, 1, 1, hh, hw),
                                    packed(means.b, 1, 4 * guides, hh, hw);
  each(half, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    double count = 0;
    for (int64_t i = 0; i < 4; ++i) count += given(b, 0, 0, row(2 * y + i / 2), column(2 * x + i % 2));
    known(b, 0, 0, y, x) = count > 0 ? 1 : 0;
    for (int64_t c = 0; c < 3; ++c) {
      for (int64_t i = 0; i < 4; ++i) {
        const int64_t yy = row(2 * y + i / 2), xx = column(2 * x + i % 2);
        half(b, 0, c, y, x) += given(b, 0, 0, yy, xx) * light(b, 0, c, yy, xx) / std::max(count, 1.0);
        half_a(b, 0, c, y, x) += given(b, 0, 0, yy, xx) * a(b, 0, c, yy, xx) / std::max(count, 1.0);
      }
      if (count == 0) half_a(b, 0, c, y, x) = 1;
      half(b, 0, c, y, x) = shown(half(b, 0, c, y, x) / half_a(b, 0, c, y, x));
    }
    for (int64_t g = 0; g < guides; ++g)
      for (int64_t i = 0; i < 4; ++i)
        packed(b, 0, 4 * g + i, y, x) = means(b, 0, guide(g), row(2 * y + i / 2), column(2 * x + i % 2));
  });
  std::vector<Grid> read;
  if (layout.reads_light) read.push_back(half);
  if (layout.reads_guides) read.push_back(packed);
  Grid deep = together(read);
  for (int64_t i = 0; i <= layout.convolutions; ++i) {
    deep = edge_convolution(deep, parameters, "super_resolution." + std::to_string(i));
    if (i < layout.convolutions)
      deep = mapped(deep, [&](double v) { return layout.tanh ? std::tanh(v) : std::max(v, 0.0); });
  }

  Grid colours(means.b, 1, 3, h, w), own_guides(means.b, 1, guides, h, w), has_light(means.b, 1, 1, h, w);
  each(colours, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    has_light(b, 0, 0, y, x) = known(b, 0, 0, y / 2, x / 2);
    for (int64_t c = 0; c < 3; ++c)
      colours(b, 0, c, y, x) = deep(b, 0, 4 * c + 2 * (y % 2) + x % 2, y / 2, x / 2);
    for (int64_t g = 0; g < guides; ++g) own_guides(b, 0, g, y, x) = means(b, 0, guide(g), y, x);
  });
  const auto relu = [](double v) { return std::max(v, 0.0); };
  Grid first = mapped(edge_convolution(together({colours, own_guides}), parameters, "denoiser.0"), relu);
  const Grid second = mapped(edge_convolution(first, parameters, "denoiser.1"), relu);
  for (size_t i = 0; i < first.values.size(); ++i) first.values[i] += second.values[i];
  Grid out = gather(bounded(edge_convolution(first, parameters, "denoiser.2"), layout), colours, has_light);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    for (int64_t c = 0; c < 3; ++c) {
      const double lit = given(b, 0, 0, y, x) > 0 ? a(b, 0, c, y, x) : half_a(b, 0, c, y / 2, x / 2);
      out(b, 0, c, y, x) = linear(out(b, 0, c, y, x)) * lit;
    }
  });
  return out;
}

}  // namespace ld::reference
