// Inner loops of ops/partition.h for one picture, float32, for every SIMD width (Highway): a tile of pixels
// at a time, one pass over its samples. Arrays are planar, [...][pitch].
#pragma once

#include "ops/kernels/filter.h"

namespace ld {

struct PartitionShape {
  int64_t samples, layers, channels, embedding;
  bool alpha;  // n_l counts the layers behind, else w_l alone
};

constexpr int64_t kPartitionPixels = 128;  // of a tile: half a page of each plane

struct PartitionInput {
  PlanarRow logits;     // [S][N]
  PlanarRow valid;      // [S]
  PlanarRow radiance;   // [S][C]
  PlanarRow embedding;  // [S][E]
};

struct PartitionOutput {
  PlanarTarget log_n;          // [N]
  PlanarTarget radiance;       // [N][C]
  PlanarTarget opacity;        // [N]
  PlanarTarget transmittance;  // [N], none unless alpha
  PlanarTarget embedding;      // [N][E]
};

/// Gradients of the outputs come in; none where there is none.
struct PartitionGradient {
  PlanarRow log_n, radiance, opacity, transmittance, embedding;
};
/// What goes out; radiance and embedding may be left out.
struct PartitionInputGradient {
  PlanarTarget logits, radiance, embedding;
};

/// One thread's memory: rows of kPartitionPixels.
struct PartitionScratch {
  StagedRows log_w;     // [S][N] log w_s^l, -inf where a sample does not count
  StagedRows share;     // [S][N] w_s^l / (S n_l)
  StagedRows weight;    // [S][N] w_s^l / S
  StagedRows term;      // [S][N] w_s^l over the largest that n_l counts
  StagedRows gradient;  // [S][N] of log w; then [S] of a sample's own share
  StagedRows pull;      // [N] of an embedding on the weights
  StagedRows mask;      // [S] all bits set where a sample counts
  explicit PartitionScratch(const PartitionShape& shape);
};

/// The first `count` pixels of all planes, count <= kPartitionPixels.
void partition_tile(const PartitionShape& shape, const PartitionInput& in, const PartitionOutput& out,
                    int64_t count, PartitionScratch& scratch);
void partition_tile_backward(const PartitionShape& shape, const PartitionInput& in,
                             const PartitionGradient& from, const PartitionInputGradient& to, int64_t count,
                             PartitionScratch& scratch);

}  // namespace ld
