#include "tests/support/scalar_networks.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tests/support/scalar_modulation.h"
#include "tests/support/scalar_super_resolution.h"

namespace ld::reference {
namespace {

/// The sum over S of [B, S, C, H, W].
Grid total(const Grid& g) {
  Grid out(g.b, 1, g.c, g.h, g.w);
  each(g, [&](int64_t b, int64_t s, int64_t y, int64_t x) {
    for (int64_t c = 0; c < g.c; ++c) out(b, 0, c, y, x) += g(b, s, c, y, x);
  });
  return out;
}

/// values over weight [B, 1, 1, H, W]; 0 where nothing arrived.
Grid divide(const Grid& values, const Grid& weight) {
  Grid out(values.b, 1, values.c, values.h, values.w);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    if (weight(b, 0, 0, y, x) > 0)
      for (int64_t c = 0; c < values.c; ++c)
        out(b, 0, c, y, x) = values(b, 0, c, y, x) / weight(b, 0, 0, y, x);
  });
  return out;
}

/// Eq. 3 to 6.
Grid filter_layers(const Grid& kernels, const Layers& layers, bool weighted) {
  const Grid radiance = splat(kernels, layers.radiance), weight = splat(kernels, layers.weight);
  return weighted ? divide(total(radiance), total(weight))
                  : composite(radiance, weight, splat(kernels, layers.occupancy));
}

struct FirstHalf {
  Grid embedding;
  std::vector<Grid> context;  // of each resolution, full first
};

/// What a network filtered, before its modulation.
struct Filtered {
  Grid picture, context;
};

FirstHalf first_half(const Samples& samples, const Parameters& parameters, const NetworkLayout& layout) {
  const Grid embedding = fully_connected(samples.features, Grid(), parameters, "sample_reducer.", true);
  return {embedding, unet(masked_mean(embedding, samples.valid), parameters, layout.unet)};
}

/// exp(-16 sigmoid(w . [E, C] + b)) for each S of the embedding, or 1 without rejection.
Grid kept(const Grid& embedding, const Grid& context, const Parameters& parameters,
          const NetworkLayout& layout) {
  Grid out(embedding.b, embedding.s, 1, embedding.h, embedding.w);
  const Grid logits =
      layout.rejects ? fully_connected(embedding, context, parameters, "rejection.weight.", false) : out;
  each(out, [&](int64_t b, int64_t s, int64_t y, int64_t x) {
    out(b, s, 0, y, x) = layout.rejects ? std::exp(-16 / (1 + std::exp(-logits(b, s, 0, y, x)))) : 1;
  });
  return out;
}

Grid scaled(Grid values, const Grid& factor) {
  each(values, [&](int64_t b, int64_t s, int64_t y, int64_t x) {
    for (int64_t c = 0; c < values.c; ++c) values(b, s, c, y, x) *= factor(b, s, 0, y, x);
  });
  return values;
}

Layers make_layers(const Samples& samples, const FirstHalf& half, const Parameters& parameters,
                   const NetworkLayout& layout) {
  const Grid logits =
      fully_connected(half.embedding, half.context[0], parameters, "sample_partitioner.", false);
  const Layers layers = partition(logits, samples.valid, samples.radiance, half.embedding);
  const Grid factor = kept(layers.embedding, half.context[0], parameters, layout);
  return {scaled(layers.weight, factor), scaled(layers.occupancy, factor), scaled(layers.radiance, factor),
          layers.embedding};
}

Filtered layer(const Samples& samples, const Parameters& parameters, const NetworkLayout& layout) {
  const FirstHalf half = first_half(samples, parameters, layout);
  const Layers layers = make_layers(samples, half, parameters, layout);
  const Grid kernels = bounded(
      fully_connected(layers.embedding, half.context[0], parameters, "kernel_generator.", false), layout);
  return {filter_layers(kernels, layers, layout.weighted), half.context[0]};
}

Filtered sample_splat(const Samples& samples, const Parameters& parameters, const NetworkLayout& layout) {
  const FirstHalf half = first_half(samples, parameters, layout);
  Grid kernels = bounded(
      fully_connected(half.embedding, half.context[0], parameters, "kernel_generator.", false), layout);
  Grid values = samples.radiance, ones = samples.valid;
  each(values, [&](int64_t b, int64_t s, int64_t y, int64_t x) {
    if (samples.valid(b, s, 0, y, x) != 0) return;
    for (int64_t c = 0; c < values.c; ++c) values(b, s, c, y, x) = 0;
    for (int64_t t = 0; t < kernels.c; ++t) kernels(b, s, t, y, x) = -1e9;  // not the largest of any pixel
  });
  const Grid factor = kept(half.embedding, half.context[0], parameters, layout);
  return {divide(total(splat(kernels, scaled(values, factor))), total(splat(kernels, scaled(ones, factor)))),
          half.context[0]};
}

FirstHalf first_half_of_pixels(const Samples& samples, const Parameters& parameters,
                               const NetworkLayout& layout) {
  const Grid embedding = fully_connected(statistics(samples.features, samples.valid), Grid(), parameters,
                                         "sample_reducer.", true);
  return {embedding, unet(embedding, parameters, layout.unet)};
}

Filtered pixel(const Samples& samples, const Parameters& parameters, const NetworkLayout& layout,
               bool gathers) {
  const FirstHalf half = first_half_of_pixels(samples, parameters, layout);
  const Grid &embedding = half.embedding, &context = half.context[0];
  const Grid kernels =
      bounded(fully_connected(embedding, context, parameters, "kernel_generator.", false), layout);
  const Grid radiance = masked_mean(samples.radiance, samples.valid);
  const Grid given = drawn(samples.valid);
  if (gathers) return {gather(kernels, radiance, given), context};
  const Grid sent = scaled(given, kept(embedding, context, parameters, layout));
  return {divide(splat(kernels, scaled(radiance, sent)), splat(kernels, sent)), context};
}

/// The mean and its Gaussian blur, in the proportion that the network says.
Filtered pixel_blend(const Samples& samples, const Parameters& parameters, const NetworkLayout& layout) {
  const FirstHalf half = first_half_of_pixels(samples, parameters, layout);
  const Grid logits = fully_connected(half.embedding, half.context[0], parameters, "blend.", false);
  const Grid mean = masked_mean(samples.radiance, samples.valid), given = drawn(samples.valid);
  const int64_t size = layout.kernel_size;
  Grid gaussian(mean.b, 1, size * size, mean.h, mean.w);
  each(gaussian, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    for (int64_t t = 0; t < gaussian.c; ++t) {
      const int64_t row = t / size - size / 2, column = t % size - size / 2;
      const double dy = double(row), dx = double(column), sigma = double(size) / 6;
      gaussian(b, 0, t, y, x) = -(dx * dx + dy * dy) / (2 * sigma * sigma);
    }
  });
  Grid out = gather(gaussian, mean, given);
  each(out, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    const double kept = given(b, 0, 0, y, x) / (1 + std::exp(-logits(b, 0, 0, y, x)));
    for (int64_t c = 0; c < out.c; ++c)
      out(b, 0, c, y, x) = kept * mean(b, 0, c, y, x) + (1 - kept) * out(b, 0, c, y, x);
  });
  return {out, half.context[0]};
}

/// Sums over blocks of 2^level x 2^level pixels.
Grid block_sum(const Grid& g, int64_t level) {
  const int64_t scale = int64_t(1) << level;
  Grid out(g.b, g.s, g.c, (g.h + scale - 1) / scale, (g.w + scale - 1) / scale);
  each(g, [&](int64_t b, int64_t s, int64_t y, int64_t x) {
    for (int64_t c = 0; c < g.c; ++c) out(b, s, c, y / scale, x / scale) += g(b, s, c, y, x);
  });
  return out;
}

/// 1 where a kernel reaches from a pixel that is not 0.
Grid reached(const Grid& pixels, int64_t kernel_size) {
  Grid out(pixels.b, 1, 1, pixels.h, pixels.w);
  each(pixels, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    for (int64_t i = 0; i < kernel_size * kernel_size && pixels(b, 0, 0, y, x) > 0; ++i) {
      const int64_t yy = y + i / kernel_size - kernel_size / 2, xx = x + i % kernel_size - kernel_size / 2;
      if (yy >= 0 && yy < pixels.h && xx >= 0 && xx < pixels.w) out(b, 0, 0, yy, xx) = 1;
    }
  });
  return out;
}

/// Eq. 10. Of each level the weights of its generator, and what is filtered by its kernels; the logits of
/// lambda follow `first` others of layer 0.
Grid blended_levels(const Samples& samples, const Layers& layers, const std::vector<Grid>& context,
                    const Parameters& parameters, const NetworkLayout& layout,
                    const std::vector<std::string>& generators, const Grid& lambda_logits, int64_t first) {
  const int64_t taps = layout.kernel_size * layout.kernel_size, h = samples.valid.h, w = samples.valid.w;
  Grid sum(samples.valid.b, 1, layers.radiance.c, h, w), lambda_sum(samples.valid.b, 1, 1, h, w);
  for (int64_t level = 0; level < layout.levels; ++level) {
    const Grid pixels = block_sum(drawn(samples.valid), level);
    Layers coarse = {block_sum(layers.weight, level), block_sum(layers.occupancy, level),
                     block_sum(layers.radiance, level), block_sum(layers.embedding, level)};
    each(coarse.embedding, [&](int64_t b, int64_t l, int64_t y, int64_t x) {
      for (int64_t c = 0; c < coarse.embedding.c; ++c)
        coarse.embedding(b, l, c, y, x) /= std::max(pixels(b, 0, 0, y, x), 1.0);
    });
    const Grid outputs = bounded(fully_connected(coarse.embedding, context[size_t(level)], parameters,
                                                 generators[size_t(level)], false),
                                 layout);
    Grid kernels(outputs.b, outputs.s, taps, outputs.h, outputs.w);
    each(kernels, [&](int64_t b, int64_t l, int64_t y, int64_t x) {
      for (int64_t t = 0; t < taps; ++t) kernels(b, l, t, y, x) = outputs(b, l, t, y, x);
    });
    const int64_t scale = int64_t(1) << level;
    const Grid global =
        resize(upsample(filter_layers(kernels, coarse, layout.weighted), scale, layout.unet.bilinear), h, w);
    const Grid coverage =
        resize(upsample(reached(pixels, layout.kernel_size), scale, layout.unet.bilinear), h, w);
    // The mean of what arrived, times lambda: a level counts by how much of it arrived.
    each(sum, [&](int64_t b, int64_t, int64_t y, int64_t x) {
      const double lambda = std::exp(lambda_logits(b, 0, first + level, y, x));
      for (int64_t c = 0; c < sum.c; ++c) sum(b, 0, c, y, x) += lambda * global(b, 0, c, y, x);
      lambda_sum(b, 0, 0, y, x) += lambda * coverage(b, 0, 0, y, x);
    });
  }
  return divide(sum, lambda_sum);
}

Filtered optimized(const Samples& samples, const Parameters& parameters, const NetworkLayout& layout) {
  const FirstHalf half = first_half(samples, parameters, layout);
  const Layers layers = make_layers(samples, half, parameters, layout);
  std::vector<std::string> generators;
  for (int64_t level = 0; level < layout.levels; ++level)
    generators.push_back("kernel_generator" + std::to_string(level) + ".");
  const Grid outputs =
      bounded(fully_connected(layers.embedding, half.context[0], parameters, generators[0], false), layout);
  return {blended_levels(samples, layers, half.context, parameters, layout, generators, outputs,
                         layout.kernel_size * layout.kernel_size),
          half.context[0]};
}

/// The pixels as one layer of several resolutions.
Filtered pixel_pyramid(const Samples& samples, const Parameters& parameters, const NetworkLayout& layout) {
  const FirstHalf half = first_half_of_pixels(samples, parameters, layout);
  const Grid &embedding = half.embedding, &context = half.context[0];
  const Grid sent = scaled(drawn(samples.valid), kept(embedding, context, parameters, layout));
  const Layers layer = {sent, sent, scaled(masked_mean(samples.radiance, samples.valid), sent),
                        scaled(embedding, drawn(samples.valid))};  // as layers without samples have zeros
  std::vector<std::string> generators = {"kernel_generator."};
  for (int64_t level = 1; level < layout.levels; ++level)
    generators.push_back("levels.kernel_generator" + std::to_string(level) + ".");
  const Grid logits = fully_connected(embedding, context, parameters, "levels.logits.", false);
  NetworkLayout of_one_layer = layout;
  of_one_layer.weighted = true;
  return {blended_levels(samples, layer, half.context, parameters, of_one_layer, generators, logits, 0),
          context};
}

}  // namespace

Grid statistics(const Grid& values, const Grid& valid) {
  const Grid mean = masked_mean(values, valid);
  Grid out(values.b, 1, 2 * values.c, values.h, values.w);
  each(mean, [&](int64_t b, int64_t, int64_t y, int64_t x) {
    double count = 0;
    for (int64_t s = 0; s < values.s; ++s) count += valid(b, s, 0, y, x) != 0 ? 1 : 0;
    for (int64_t c = 0; c < values.c; ++c) {
      out(b, 0, c, y, x) = mean(b, 0, c, y, x);
      for (int64_t s = 0; s < values.s; ++s)
        if (valid(b, s, 0, y, x) != 0)
          out(b, 0, values.c + c, y, x) += std::pow(values(b, s, c, y, x) - mean(b, 0, c, y, x), 2) / count;
    }
  });
  return out;
}

namespace {

Filtered filtered(const std::string& name, const Samples& samples, const Parameters& parameters,
                  const NetworkLayout& layout) {
  if (name == "layer" || name == "layer_history") return layer(samples, parameters, layout);
  if (name == "sample_splat") return sample_splat(samples, parameters, layout);
  if (name == "pixel_blend") return pixel_blend(samples, parameters, layout);
  if (name == "pixel_gather") return pixel(samples, parameters, layout, true);
  if (name == "pixel_splat") return pixel(samples, parameters, layout, false);
  if (name == "optimized") return optimized(samples, parameters, layout);
  if (name == "pixel_pyramid") return pixel_pyramid(samples, parameters, layout);
  throw std::invalid_argument("no scalar reference of the network " + name);
}

}  // namespace

Grid network(const std::string& name, const Samples& samples, const Parameters& parameters,
             const NetworkLayout& layout) {
  if (name == "espcn_kpcn") return espcn_kpcn(samples, parameters, layout);
  if (!layout.demodulates) return filtered(name, samples, parameters, layout).picture;
  const Grid a = demodulator(samples.features, layout), of_pixels = statistics(a, samples.valid);
  Samples demodulated = samples;
  demodulated.radiance = both_forms(samples.radiance, a);
  const Filtered both = filtered(name, demodulated, parameters, layout);
  const Grid beta_logits =
      fully_connected(steadiness(of_pixels), both.context, parameters, "modulation.weight.", false);
  return modulated(both.picture, of_pixels, beta_logits);
}

}  // namespace ld::reference
