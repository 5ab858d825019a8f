#include "dataset/augmentation.h"

#include <algorithm>
#include <cmath>

namespace ld {
namespace {

/// The index of one of the weights, by its share of their sum.
size_t draw_by_weight(RandomStream& stream, const std::vector<double>& weights) {
  double sum = 0;
  for (const double weight : weights) sum += weight;
  if (!(sum > 0)) return stream.below(static_cast<uint32_t>(weights.size()));
  double left = sum * static_cast<double>(stream.uniform());
  for (size_t i = 0; i + 1 < weights.size(); ++i) {
    if (left < weights[i]) return i;
    left -= weights[i];
  }
  return weights.size() - 1;
}

}  // namespace

double crop_difficulty(const PackedFrame& frame, int x, int y, int width, int height) {
  const TileRange range = PackedFrame::tiles_of(x, y, width, height);
  double sum = 0;
  for (int tile_y = range.y0; tile_y < range.y1; ++tile_y)
    for (int tile_x = range.x0; tile_x < range.x1; ++tile_x) {
      const int columns = std::min(x + width, (tile_x + 1) * kTileSide) - std::max(x, tile_x * kTileSide);
      const int rows = std::min(y + height, (tile_y + 1) * kTileSide) - std::max(y, tile_y * kTileSide);
      sum += double(columns) * rows * frame.difficulty[tile_y * frame.tiles_x() + tile_x];
    }
  return sum / (double(width) * height);
}

Augmentation random_augmentation(RandomStream& stream, const std::vector<const PackedFrame*>& clip,
                                 const AugmentationOptions& options) {
  const PackedFrame& frame = *clip.front();
  Augmentation a;
  a.width = std::min(options.crop, frame.width);
  a.height = std::min(options.crop, frame.height);
  const auto draw_position = [&] {
    const int m = options.multiple;
    a.x = m * static_cast<int>(stream.below(static_cast<uint32_t>((frame.width - a.width) / m + 1)));
    a.y = m * static_cast<int>(stream.below(static_cast<uint32_t>((frame.height - a.height) / m + 1)));
  };
  draw_position();
  if (options.candidates > 1) {
    std::vector<Augmentation> candidates = {a};
    while (candidates.size() < static_cast<size_t>(options.candidates)) {
      draw_position();
      candidates.push_back(a);
    }
    std::vector<double> weights;
    for (const Augmentation& candidate : candidates) {
      weights.push_back(0);
      for (const PackedFrame* of_clip : clip)
        weights.back() += crop_difficulty(*of_clip, candidate.x, candidate.y, a.width, a.height);
    }
    a = candidates[draw_by_weight(stream, weights)];
  }
  if (options.flips) {
    a.flip_x = stream.below(2) == 1;
    a.flip_y = stream.below(2) == 1;
  }
  if (options.rotations) a.quarter_turns = static_cast<int>(stream.below(4));
  if (options.exposure > 0) a.exposure.fill(std::exp2(stream.uniform(-options.exposure, options.exposure)));
  if (options.colours)
    for (uint32_t order = stream.below(6); order > 0; --order)
      std::next_permutation(a.colours.begin(), a.colours.end());
  if (options.reversal) a.reversed = stream.below(2) == 1;
  if (options.tint > 0)
    for (float& factor : a.exposure) factor *= stream.uniform(0, options.tint);
  if (options.stop > 0 || options.freeze > 0) {
    const float drawn = stream.uniform();
    const auto length = static_cast<uint32_t>(clip.size());
    if (drawn < options.stop)
      a.last_frame = 0;
    else if (drawn < options.stop + options.freeze && length > 2)
      a.last_frame = static_cast<int>(1 + stream.below(length - 2));
  }
  return a;
}

}  // namespace ld
