// What a pixel's samples have together.
#include <algorithm>
#include <limits>

#include "ops/kernels/sample_tile.h"
#include "ops/kernels/tone_map_row.h"
#include "runtime/tile_step.h"

namespace ld {
std::unique_ptr<TileStep> make_step(const graph::MaskedMean&, const graph::Node& node, StepContext& context) {
  const RowWindow values = context.input(node, 0), valid = context.input(node, 1), out = context.output(node);
  return tile_step(context, kTilePixels, [=](const PixelTile& tile, float* share) {
    const PlanarRow x = values.at(tile), drawn = valid.at(tile);
    const int64_t pixels = padded(tile.count);
    valid_shares(drawn, valid.planes, pixels, share);
    for (int64_t c = 0; c < out.planes; ++c)
      mean_of_items({x.plane(c), out.planes * x.pitch}, drawn, share, valid.planes, pixels,
                    out.at(tile, c).data);
  });
}

std::unique_ptr<TileStep> make_step(const graph::Statistics&, const graph::Node& node, StepContext& context) {
  const RowWindow values = context.input(node, 0), valid = context.input(node, 1), out = context.output(node);
  return tile_step(context, kTilePixels, [=](const PixelTile& tile, float* share) {
    const PlanarRow x = values.at(tile), drawn = valid.at(tile);
    const int64_t pixels = padded(tile.count), channels = out.planes / 2;
    valid_shares(drawn, valid.planes, pixels, share);
    for (int64_t c = 0; c < channels; ++c)
      moments_of_items({x.plane(c), channels * x.pitch}, drawn, share, valid.planes, pixels,
                       out.at(tile, c).data, out.at(tile, channels + c).data);
  });
}

std::unique_ptr<TileStep> make_step(const graph::AnyValid&, const graph::Node& node, StepContext& context) {
  const RowWindow valid = context.input(node, 0), out = context.output(node);
  return tile_step(context, 0, [=](const PixelTile& tile, float*) {
    const PlanarRow drawn = valid.at(tile);
    float* any = out.at(tile).data;
    for (int64_t x = 0; x < tile.count; ++x) {
      any[x] = 0;
      for (int64_t s = 0; s < valid.planes; ++s) any[x] = std::max(any[x], drawn.plane(s)[x]);
    }
  });
}

std::unique_ptr<TileStep> make_step(const graph::LogValid&, const graph::Node& node, StepContext& context) {
  const RowWindow valid = context.input(node, 0), out = context.output(node);
  return tile_step(context, 0, [=](const PixelTile& tile, float*) {
    for (int64_t s = 0; s < valid.planes; ++s)
      for (int64_t x = 0; x < tile.count; ++x)
        out.at(tile, s).data[x] =
            valid.at(tile, s).data[x] != 0 ? 0.0f : -std::numeric_limits<float>::infinity();
  });
}

std::unique_ptr<TileStep> make_step(const graph::FirstValid&, const graph::Node& node, StepContext& context) {
  const RowWindow values = context.input(node, 0), valid = context.input(node, 1), out = context.output(node);
  return tile_step(context, 0, [=](const PixelTile& tile, float*) {
    const PlanarRow drawn = valid.at(tile), from = values.at(tile);
    const PlanarTarget to = out.at(tile);
    const int64_t channels = values.planes / valid.planes;
    for (int64_t x = 0; x < tile.count; ++x) {
      int64_t first = 0;
      while (first + 1 < valid.planes && drawn.plane(first)[x] == 0) ++first;
      if (drawn.plane(first)[x] == 0) first = 0;
      for (int64_t s = 0; s < valid.planes; ++s) {
        const int64_t source = drawn.plane(s)[x] != 0 ? s : first;
        for (int64_t c = 0; c < channels; ++c)
          to.plane(s * channels + c)[x] = from.plane(source * channels + c)[x];
      }
    }
  });
}

std::unique_ptr<TileStep> make_step(const graph::ToneMapped& op, const graph::Node& node,
                                    StepContext& context) {
  const RowWindow values = context.input(node, 0), radiance = context.input(node, 1),
                  valid = context.input(node, 2), out = context.output(node);
  return tile_step(context, 0, [=, &context](const PixelTile& tile, float*) {
    for (int64_t c = 0; c < out.planes; ++c)
      std::copy_n(values.at(tile, c).data, tile.count, out.at(tile, c).data);
    for (int64_t c = 0; c < 3; ++c) {
      float* tone = out.at(tile, op.first + c).data;
      expose_row(radiance.at(tile, c).data, context.source->light.exposure, tone, tile.count);
      tone_map_row(tone, tone, tile.count);
    }
    mask_planes(out.at(tile, op.first), 3, valid.at(tile).data, padded(tile.count));
  });
}

}  // namespace ld
