// The layers at halved resolutions, and what their pictures come to ([MH20] section 6).
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "runtime/row_step.h"
#include "runtime/tile_step.h"

namespace ld {
namespace {

constexpr float kNothing = -std::numeric_limits<float>::infinity();

/// Of Halve. Ratios are averaged, not products with n, which may underflow.
struct HalveRow {
  RowWindow log_n, pixels, embedding, coarse_log_n, coarse_pixels, coarse_embedding;
  std::vector<RowWindow> values, coarse_values;

  int64_t scratch() const { return 4 * coarse_log_n.pitch; }

  /// `share` [4]: what the four fine pixels have in each coarse one.
  void operator()(int64_t y, float* share) const {
    const int64_t layers = log_n.planes;
    for (int64_t l = 0; l < layers; ++l) {
      shares_of_log_n(y, l, share);
      for (size_t i = 0; i < values.size(); ++i) average(values[i], coarse_values[i], y, l, share);
    }
    shares_of_pixels(y, share);
    for (int64_t l = 0; l < layers; ++l) average(embedding, coarse_embedding, y, l, share);
  }

  /// The four fine pixels of a coarse one; `missing` for those beyond an odd border.
  static std::array<float, 4> four(const RowWindow& fine, int64_t y, int64_t plane, int64_t x,
                                   float missing) {
    const auto pixel = [&](int64_t v, int64_t u) {
      return v < fine.height && u < fine.width ? fine.row(v, plane)[u] : missing;
    };
    return {pixel(2 * y, 2 * x), pixel(2 * y, 2 * x + 1), pixel(2 * y + 1, 2 * x),
            pixel(2 * y + 1, 2 * x + 1)};
  }

  void set(float* share, int64_t x, const std::array<float, 4>& weights, float sum) const {
    for (size_t i = 0; i < 4; ++i) share[int64_t(i) * coarse_log_n.pitch + x] = weights[i] / sum;
  }

  /// log n of the mean of n, and what each pixel has in that.
  void shares_of_log_n(int64_t y, int64_t layer, float* share) const {
    for (int64_t x = 0; x < coarse_log_n.width; ++x) {
      std::array<float, 4> weights = four(log_n, y, layer, x, kNothing);
      const float largest = *std::max_element(weights.begin(), weights.end());
      float sum = 0;
      for (float& weight : weights) sum += weight = largest == kNothing ? 0 : std::exp(weight - largest);
      set(share, x, weights, std::max(sum, 1.0f));
      coarse_log_n.row(y, layer)[x] = largest + std::log(std::max(sum, 1.0f) / 4);
    }
  }

  /// Pixels with samples count alike.
  void shares_of_pixels(int64_t y, float* share) const {
    for (int64_t x = 0; x < coarse_pixels.width; ++x) {
      const std::array<float, 4> counts = four(pixels, y, 0, x, 0);
      const float sum = counts[0] + counts[1] + counts[2] + counts[3];
      set(share, x, counts, std::max(sum, 1.0f));
      coarse_pixels.row(y)[x] = sum;
    }
  }

  /// The channels of a layer. Pixels beyond the border have no share.
  void average(const RowWindow& fine, const RowWindow& coarse, int64_t y, int64_t layer,
               const float* share) const {
    const int64_t channels = fine.planes / log_n.planes, pitch = coarse_log_n.pitch;
    const float* __restrict s0 = share;
    const float* __restrict s1 = share + pitch;
    const float* __restrict s2 = share + 2 * pitch;
    const float* __restrict s3 = share + 3 * pitch;
    for (int64_t c = layer * channels; c < (layer + 1) * channels; ++c) {
      const float* __restrict upper = fine.row(2 * y, c);
      const float* __restrict lower = fine.row(std::min(2 * y + 1, fine.height - 1), c);
      float* __restrict to = coarse.row(y, c);
      for (int64_t x = 0; x < fine.width / 2; ++x)
        to[x] =
            s0[x] * upper[2 * x] + s1[x] * upper[2 * x + 1] + s2[x] * lower[2 * x] + s3[x] * lower[2 * x + 1];
      if (const int64_t x = fine.width / 2; x < coarse.width)
        to[x] = s0[x] * upper[2 * x] + s2[x] * lower[2 * x];
    }
  }
};

/// Of BlendLevels. A pixel that received nothing is 0 in its level's picture. Upscaling blends it with its
/// neighbours, and dividing by what the upscaled pixel has of those that received something leaves their
/// mean.
struct BlendLevelsTile {
  RowWindow logits, out;
  std::vector<RowWindow> pictures, received;

  int64_t scratch() const { return (2 + logits.planes) * kTilePixels; }

  void operator()(const PixelTile& tile, float* memory) const {
    const int64_t count = tile.count, levels = logits.planes;
    float *largest = memory, *sum = largest + kTilePixels, *weights = sum + kTilePixels;
    const auto coverage_of = [&](int64_t i) { return received[size_t(i)].at(tile).data; };
    const auto logits_of = [&](int64_t i) { return logits.at(tile, i).data; };
    std::fill_n(largest, count, kNothing);
    for (int64_t i = 0; i < levels; ++i)
      for (int64_t x = 0; x < count; ++x)
        if (coverage_of(i)[x] > 0) largest[x] = std::max(largest[x], logits_of(i)[x]);
    std::fill_n(sum, count, 0.0f);
    for (int64_t i = 0; i < levels; ++i) {
      const float* coverage = coverage_of(i);
      float* weight = weights + i * kTilePixels;
      for (int64_t x = 0; x < count; ++x) {
        weight[x] = coverage[x] > 0 ? std::exp(logits_of(i)[x] - largest[x]) : 0.0f;
        sum[x] += coverage[x] * weight[x];
      }
    }
    for (int64_t x = 0; x < count; ++x) sum[x] = sum[x] > 0 ? sum[x] : 1.0f;
    for (int64_t c = 0; c < out.planes; ++c) {
      float* __restrict to = out.at(tile, c).data;
      std::fill_n(to, count, 0.0f);
      for (int64_t i = 0; i < levels; ++i) {
        const float* __restrict picture = pictures[size_t(i)].at(tile, c).data;
        const float* __restrict weight = weights + i * kTilePixels;
        for (int64_t x = 0; x < count; ++x) to[x] += weight[x] / sum[x] * picture[x];
      }
    }
  }
};

}  // namespace

std::unique_ptr<Step> make_step(const graph::Halve&, const graph::Node& node, StepContext& context) {
  HalveRow row = {context.input(node, 0),
                  context.input(node, 1),
                  context.input(node, 2),
                  context.output(node, 0),
                  context.output(node, 1),
                  context.output(node, 2),
                  {},
                  {}};
  for (size_t i = 3; i < node.inputs.size(); ++i) {
    row.values.push_back(context.input(node, i));
    row.coarse_values.push_back(context.output(node, i));
  }
  return row_step(context, node, row.scratch(), row);
}
std::unique_ptr<Step> make_step(const graph::Received& op, const graph::Node& node, StepContext& context) {
  const RowWindow pixels = context.input(node, 0), out = context.output(node);
  const int64_t radius = op.kernel / 2;
  return row_step(context, node, 0, [=](int64_t y, float*) {
    std::fill_n(out.row(y), out.width, 0.0f);
    for (int64_t v = std::max<int64_t>(y - radius, 0); v <= std::min(y + radius, pixels.height - 1); ++v) {
      const float* from = pixels.row(v);
      for (int64_t x = 0; x < pixels.width; ++x)
        if (from[x] > 0)
          std::fill(out.row(y) + std::max<int64_t>(x - radius, 0),
                    out.row(y) + std::min(x + radius + 1, out.width), 1.0f);
    }
  });
}
std::unique_ptr<TileStep> make_step(const graph::BlendLevels&, const graph::Node& node,
                                    StepContext& context) {
  BlendLevelsTile tile = {context.input(node, 0), context.output(node), {}, {}};
  for (size_t i = 1; i < node.inputs.size(); i += 2) {
    tile.pictures.push_back(context.input(node, i));
    tile.received.push_back(context.input(node, i + 1));
  }
  return tile_step(context, tile.scratch(), tile);
}

}  // namespace ld
