// What a recurrent autoencoder sees of a frame and hands on to the next (models/recurrent.h).
#include <algorithm>
#include <cmath>

#include "core/tone_map.h"
#include "models/network_numbers.h"
#include "ops/kernels/sample_tile.h"
#include "runtime/row_step.h"
#include "runtime/tile_step.h"

namespace ld {
namespace {

/// Of TakeRoots.
struct TakeRootsTile {
  graph::TakeRoots op;
  RowWindow features, radiance, valid, seen, texture, emission;

  int64_t scratch() const { return (valid.planes + 2) * kTilePixels; }

  void operator()(const PixelTile& tile, float* memory) const {
    float *share = memory, *other = memory + kTilePixels, *of_samples = memory + 2 * kTilePixels;
    const int64_t samples = valid.planes, channels = features.planes / samples, pixels = padded(tile.count);
    const PlanarRow drawn = valid.at(tile), all = features.at(tile), light = radiance.at(tile);
    valid_shares(drawn, samples, pixels, share);
    const auto mean = [&](PlanarRow values, float* to) {
      mean_of_items(values, drawn, share, samples, pixels, to);
    };
    const auto mean_of_feature = [&](int64_t first, int64_t c, float* to) {
      if (first < 0)
        std::fill_n(to, pixels, 0.0f);
      else
        mean({all.plane(first + c), channels * all.pitch}, to);
    };
    for (int64_t c = 0; c < 3; ++c) {
      float* __restrict a = texture.at(tile, c).data;
      mean_of_feature(op.albedo, c, a);
      mean_of_feature(op.specular, c, other);
      for (int64_t x = 0; x < pixels; ++x) a[x] = root(std::max(a[x] + other[x], float(kLeastTexture)));
      clear_texture(drawn, tile.count, a);

      float* __restrict e = emission.at(tile, c).data;
      for (int64_t s = 0; s < samples; ++s)
        emitted(all, light, s * channels, 3 * s + c, c, pixels, of_samples + s * kTilePixels);
      mean({of_samples, kTilePixels}, e);
      float* __restrict to = seen.at(tile, c).data;
      mean({light.plane(c), 3 * light.pitch}, to);
      for (int64_t x = 0; x < pixels; ++x) {
        e[x] = std::min(e[x], float(kLargestEmission));
        to[x] = root(std::max(to[x] - float(1 + kLeastBesideEmission) * e[x], 0.0f)) / a[x];
      }
    }
    for (int64_t c = 0; c < 2; ++c) mean_of_feature(op.normal, c, seen.at(tile, 3 + c).data);
    mean_of_feature(op.depth, 0, seen.at(tile, 5).data);
    mean_of_feature(op.roughness, 0, seen.at(tile, 6).data);
  }

 private:
  static float root(float x) { return x == 0 ? 0 : std::pow(x, float(kLightPower)); }

  /// 1 where a pixel has no sample.
  void clear_texture(PlanarRow drawn, int64_t count, float* texture_row) const {
    for (int64_t x = 0; x < count; ++x) {
      bool any = false;
      for (int64_t s = 0; s < valid.planes; ++s) any = any || drawn.plane(s)[x] != 0;
      if (!any) texture_row[x] = 1;
    }
  }

  /// Of a sample, whose features begin at plane `first` and whose radiance is plane `light_plane`.
  void emitted(PlanarRow all, PlanarRow light, int64_t first, int64_t light_plane, int64_t c, int64_t pixels,
               float* __restrict to) const {
    if (op.emission < 0) {
      std::fill_n(to, pixels, 0.0f);
    } else {
      const float* __restrict encoded = all.plane(first + op.emission + c);
      for (int64_t x = 0; x < pixels; ++x) to[x] = tone_map_inverse(encoded[x]);
    }
    if (op.depth < 0) return;
    const float* __restrict depth = all.plane(first + op.depth);
    const float* __restrict radiance_row = light.plane(light_plane);
    for (int64_t x = 0; x < pixels; ++x) to[x] = depth[x] >= 1 ? radiance_row[x] : to[x];
  }
};

}  // namespace

std::unique_ptr<TileStep> make_step(const graph::TakeRoots& op, const graph::Node& node,
                                    StepContext& context) {
  const TakeRootsTile tile = {op,
                              context.input(node, 0),
                              context.input(node, 1),
                              context.input(node, 2),
                              context.output(node, 0),
                              context.output(node, 1),
                              context.output(node, 2)};
  return tile_step(context, tile.scratch(), tile);
}

std::unique_ptr<TileStep> make_step(const graph::RaiseRoots&, const graph::Node& node, StepContext& context) {
  const RowWindow predicted = context.input(node, 0), texture = context.input(node, 1),
                  emission = context.input(node, 2), out = context.output(node);
  return tile_step(context, 0, [=](const PixelTile& tile, float*) {
    for (int64_t c = 0; c < 3; ++c) {
      const float* __restrict p = predicted.at(tile, c).data;
      const float* __restrict a = texture.at(tile, c).data;
      const float* __restrict e = emission.at(tile, c).data;
      float* __restrict to = out.at(tile, c).data;
      for (int64_t x = 0; x < tile.count; ++x) {
        const float light = std::min(std::max(p[x], 0.0f) * a[x], float(kLargestRoot)),
                    square = light * light;
        to[x] = square * square * light + e[x];
      }
    }
  });
}

std::unique_ptr<Step> make_step(const graph::RecallPart& op, const graph::Node& node, StepContext& context) {
  const RowWindow out = context.output(node);
  return row_step(context, node, 0, [=, &context](int64_t y, float*) {
    for (int64_t c = 0; c < out.planes; ++c) {
      float* to = out.row(y, c);
      std::fill_n(to, padded(out.width), 0.0f);
      if (op.part < 0 || context.before == nullptr) continue;
      const Image& left = (*context.before)[size_t(op.part)];
      const float* __restrict from = left.pixels.data() + (c * left.height + y) * left.width;
      for (int64_t x = 0; x < out.width; ++x)
        to[x] = std::min(std::max(from[x], -float(kLargestState)), float(kLargestState));
    }
  });
}

}  // namespace ld
