#include "ops/kernels/partition_tile.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "ops/kernels/partition_tile.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "ops/kernels/exponential-inl.h"

HWY_BEFORE_NAMESPACE();
namespace ld {
namespace HWY_NAMESPACE {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
// Bound of a product in the gradient of a share. A gradient times a radiance of 3e38 may overflow although
// the share, with which it is multiplied next, is 0: that must not become NaN. Room for three channels and 64
// samples.
constexpr float kLargestProduct = std::numeric_limits<float>::max() / 1024;

/// A vector of which `count` lanes are in the picture, 0 in the others.
HWY_INLINE V load(D d, const float* from, int64_t count) {
  if (count >= lanes()) return hn::LoadU(d, from);
  HWY_ALIGN float lane[HWY_MAX_BYTES / sizeof(float)] = {};
  std::copy_n(from, count, lane);
  return hn::Load(d, lane);
}

HWY_INLINE void store(D d, V v, float* to, int64_t count) {
  if (count >= lanes()) return hn::StoreU(v, d, to);
  HWY_ALIGN float lane[HWY_MAX_BYTES / sizeof(float)];
  hn::Store(v, d, lane);
  std::copy_n(lane, count, to);
}

/// The pixels of a tile, by vectors: x of the tile, `left` pixels from there on.
struct Tile {
  const PartitionShape& shape;
  int64_t count;
  template <class Body>
  HWY_INLINE void each(const Body& body) const {
    for (int64_t x = 0; x < count; x += lanes()) body(x, count - x);
  }
};

/// Which samples count: drawn, and of finite radiance. Returns their number.
HWY_INLINE V count_samples(D d, const Tile& tile, const PartitionInput& in, int64_t x, int64_t left,
                           PartitionScratch& scratch) {
  V count = hn::Zero(d);
  for (int64_t s = 0; s < tile.shape.samples; ++s) {
    auto counts = hn::Ne(load(d, in.valid.plane(s) + x, left), hn::Zero(d));
    for (int64_t c = 0; c < tile.shape.channels; ++c)
      counts =
          hn::And(counts, hn::Lt(hn::Abs(load(d, in.radiance.plane(tile.shape.channels * s + c) + x, left)),
                                 hn::Set(d, kInfinity)));
    hn::Store(hn::VecFromMask(d, counts), d, scratch.mask.row(s) + x);
    count = hn::Add(count, hn::IfThenElseZero(counts, hn::Set(d, 1.0f)));
  }
  return count;
}

/// Eq. 1: log w_s^l and w_s^l / S.
HWY_INLINE void weights(D d, const Tile& tile, const PartitionInput& in, int64_t x, int64_t left,
                        V inverse_count, PartitionScratch& scratch) {
  const int64_t layers = tile.shape.layers;
  for (int64_t s = 0; s < tile.shape.samples; ++s) {
    V largest = hn::Set(d, kLowestLogit);
    for (int64_t l = 0; l < layers; ++l) {
      const V z = bounded_logit(d, load(d, in.logits.plane(s * layers + l) + x, left));
      hn::Store(z, d, scratch.log_w.row(s * layers + l) + x);
      largest = hn::Max(largest, z);
    }
    V total = hn::Zero(d);
    for (int64_t l = 0; l < layers; ++l) {
      float* row = scratch.log_w.row(s * layers + l) + x;
      const V difference = hn::Sub(hn::Load(d, row), largest), e = exp_negative(d, difference);
      hn::Store(difference, d, row);
      hn::Store(e, d, scratch.weight.row(s * layers + l) + x);
      total = hn::Add(total, e);
    }
    const V log_total = hn::Log(d, total);  // of 1 to N
    const auto counts = hn::MaskFromVec(hn::Load(d, scratch.mask.row(s) + x));
    const V factor = hn::IfThenElseZero(counts, hn::Div(inverse_count, total));
    for (int64_t l = 0; l < layers; ++l) {
      float* row = scratch.log_w.row(s * layers + l) + x;
      const V log_w =
          hn::IfThenElse(counts, hn::Max(hn::Sub(hn::Load(d, row), log_total), hn::Set(d, kLowestLogit)),
                         hn::Set(d, -kInfinity));
      hn::Store(log_w, d, row);
      float* weight = scratch.weight.row(s * layers + l) + x;
      hn::Store(hn::Mul(hn::Load(d, weight), factor), d, weight);
    }
  }
}

HWY_INLINE int64_t behind(const PartitionShape& shape, int64_t l) {
  return shape.alpha ? shape.layers : l + 1;
}

/// The softmax over the samples' weights in layer l and those behind it (alpha) or in layer l alone.
struct Occupancy {
  V largest, total, inverse;
  const StagedRows* terms;  // what sample s puts into layer k, times `inverse`: a share of n_l
};

HWY_INLINE Occupancy occupancy(D d, const PartitionShape& shape, int64_t l, int64_t x,
                               PartitionScratch& scratch) {
  // n_0 counts all weights of all samples: their number, by which the weights are divided already.
  if (l == 0 && shape.alpha) return {hn::Zero(d), hn::Set(d, 1.0f), hn::Set(d, 1.0f), &scratch.weight};
  V largest = hn::Set(d, std::numeric_limits<float>::lowest());
  for (int64_t s = 0; s < shape.samples; ++s)
    for (int64_t k = l; k < behind(shape, l); ++k)
      largest = hn::Max(largest, hn::Load(d, scratch.log_w.row(s * shape.layers + k) + x));
  V total = hn::Zero(d);
  for (int64_t s = 0; s < shape.samples; ++s)
    for (int64_t k = l; k < behind(shape, l); ++k) {
      const int64_t row = s * shape.layers + k;
      const V term = exp_negative(d, hn::Sub(hn::Load(d, scratch.log_w.row(row) + x), largest));
      hn::Store(term, d, scratch.term.row(row) + x);
      total = hn::Add(total, term);
    }
  const V inverse = hn::IfThenElseZero(hn::Gt(total, hn::Zero(d)), hn::Div(hn::Set(d, 1.0f), total));
  return {largest, total, inverse, &scratch.term};
}

/// What sample s puts into layer k, as a share of n_l.
HWY_INLINE V share_of(D d, const PartitionShape& shape, const Occupancy& n, int64_t s, int64_t k, int64_t x) {
  return hn::Mul(hn::Load(d, n.terms->row(s * shape.layers + k) + x), n.inverse);
}

/// sums[l][c] = sum over s of factors[s][l] * values[s][c], for one channel, layers [l, l + kLayers) and
/// kTogether vectors of pixels: each value is read once, and enough sums are under way at a time.
template <int kLayers, int kTogether>
HWY_INLINE void sum_pixels(D d, const Tile& tile, const StagedRows& factors, const PartitionScratch& scratch,
                           PlanarRow values, int64_t channels, int64_t c, int64_t l, PlanarTarget sums,
                           int64_t x, int64_t left) {
  V sum[kLayers][kTogether];
#pragma GCC unroll 4
  for (int k = 0; k < kLayers; ++k)
#pragma GCC unroll 4
    for (int v = 0; v < kTogether; ++v) sum[k][v] = hn::Zero(d);
  const float* from = values.plane(c) + x;
  const float* mask = scratch.mask.row(0) + x;
  const float* factor = factors.row(l) + x;
  for (int64_t s = 0; s < tile.shape.samples; ++s) {
#pragma GCC unroll 4
    for (int v = 0; v < kTogether; ++v) {
      const V value =
          hn::And(load(d, from + v * lanes(), left - v * lanes()), hn::Load(d, mask + v * lanes()));
#pragma GCC unroll 4
      for (int k = 0; k < kLayers; ++k)
        sum[k][v] = hn::MulAdd(hn::Load(d, factor + k * factors.pitch() + v * lanes()), value, sum[k][v]);
    }
    from += channels * values.pitch;
    mask += scratch.mask.pitch();
    factor += tile.shape.layers * factors.pitch();
  }
#pragma GCC unroll 4
  for (int k = 0; k < kLayers; ++k)
#pragma GCC unroll 4
    for (int v = 0; v < kTogether; ++v)
      store(d, sum[k][v], sums.plane((l + k) * channels + c) + x + v * lanes(), left - v * lanes());
}

template <int kLayers>
HWY_INLINE void sum_layers(D d, const Tile& tile, const StagedRows& factors, const PartitionScratch& scratch,
                           PlanarRow values, int64_t channels, int64_t c, int64_t l, PlanarTarget sums) {
  constexpr int kTogether = 4;
  int64_t x = 0;
  for (; tile.count - x >= kTogether * lanes(); x += kTogether * lanes())
    sum_pixels<kLayers, kTogether>(d, tile, factors, scratch, values, channels, c, l, sums, x,
                                   tile.count - x);
  for (; x < tile.count; x += lanes())
    sum_pixels<kLayers, 1>(d, tile, factors, scratch, values, channels, c, l, sums, x, tile.count - x);
}

/// All channels and layers.
HWY_INLINE void sum_values(D d, const Tile& tile, const StagedRows& factors, const PartitionScratch& scratch,
                           PlanarRow values, int64_t channels, PlanarTarget sums) {
  for (int64_t c = 0; c < channels; ++c) {
    int64_t l = 0;
    for (; l + 2 <= tile.shape.layers; l += 2)
      sum_layers<2>(d, tile, factors, scratch, values, channels, c, l, sums);
    for (; l < tile.shape.layers; ++l) sum_layers<1>(d, tile, factors, scratch, values, channels, c, l, sums);
  }
}

void tile_forward(const PartitionShape& shape, const PartitionInput& in, const PartitionOutput& out,
                  int64_t count, PartitionScratch& scratch) {
  const D d;
  const Tile tile{shape, count};
  tile.each([&](int64_t x, int64_t left) {
    const V samples = count_samples(d, tile, in, x, left, scratch);
    const auto any = hn::Gt(samples, hn::Zero(d));
    weights(d, tile, in, x, left, hn::IfThenElseZero(any, hn::Div(hn::Set(d, 1.0f), samples)), scratch);
    for (int64_t l = 0; l < shape.layers; ++l) {
      const Occupancy n = occupancy(d, shape, l, x, scratch);
      V opacity = hn::Zero(d), transmittance = hn::Zero(d);
      for (int64_t s = 0; s < shape.samples; ++s) {
        const V share = share_of(d, shape, n, s, l, x);
        hn::Store(share, d, scratch.share.row(s * shape.layers + l) + x);
        opacity = hn::Add(opacity, share);
        for (int64_t k = l + 1; k < behind(shape, l); ++k)
          transmittance = hn::Add(transmittance, share_of(d, shape, n, s, k, x));
      }
      V log_n = hn::Zero(d);  // n_0 = 1
      if (l > 0 || !shape.alpha)
        log_n = hn::Add(n.largest, hn::Sub(hn::Log(d, n.total), hn::Log(d, samples)));
      store(d, hn::IfThenElse(any, log_n, hn::Set(d, -kInfinity)), out.log_n.plane(l) + x, left);
      store(d, opacity, out.opacity.plane(l) + x, left);
      if (out.transmittance.data != nullptr) store(d, transmittance, out.transmittance.plane(l) + x, left);
    }
  });
  sum_values(d, tile, scratch.share, scratch, in.radiance, shape.channels, out.radiance);
  sum_values(d, tile, scratch.weight, scratch, in.embedding, shape.embedding, out.embedding);
}

HWY_INLINE V load_gradient(D d, PlanarRow gradient, int64_t plane, int64_t x, int64_t left) {
  return gradient.data == nullptr ? hn::Zero(d) : load(d, gradient.plane(plane) + x, left);
}

/// A gradient times a value, within what the sums that follow can hold.
HWY_INLINE V bounded_product(D d, V gradient, V value) {
  const V product = hn::Mul(gradient, value);
  return hn::Max(hn::Min(product, hn::Set(d, kLargestProduct)), hn::Set(d, -kLargestProduct));
}

/// Through the shares of n_l: adds to the gradients of log w.
HWY_INLINE void layer_backward(D d, const Tile& tile, const PartitionInput& in, const PartitionGradient& from,
                               int64_t l, int64_t x, int64_t left, PartitionScratch& scratch) {
  const PartitionShape& shape = tile.shape;
  const Occupancy n = occupancy(d, shape, l, x, scratch);
  const V of_opacity = load_gradient(d, from.opacity, l, x, left),
          of_transmittance = load_gradient(d, from.transmittance, l, x, left),
          of_log_n = l > 0 || !shape.alpha ? load_gradient(d, from.log_n, l, x, left) : hn::Zero(d);
  V mean = hn::Zero(d);  // of the gradients of the shares, weighted by them: a softmax's own
  for (int64_t s = 0; s < shape.samples; ++s) {
    V pull = of_opacity;
    for (int64_t c = 0; c < shape.channels; ++c) {
      const V value = hn::And(load(d, in.radiance.plane(shape.channels * s + c) + x, left),
                              hn::Load(d, scratch.mask.row(s) + x));
      pull = hn::Add(
          pull, bounded_product(d, load_gradient(d, from.radiance, shape.channels * l + c, x, left), value));
    }
    const V share = share_of(d, shape, n, s, l, x);
    hn::Store(share, d, scratch.share.row(s * shape.layers + l) + x);
    // Kept where it is used next: the gradient of this sample's share of its own layer.
    hn::Store(pull, d, scratch.gradient.row(shape.samples * shape.layers + s) + x);
    mean = hn::MulAdd(share, pull, mean);
    for (int64_t k = l + 1; k < behind(shape, l); ++k)
      mean = hn::MulAdd(share_of(d, shape, n, s, k, x), of_transmittance, mean);
  }
  const V offset = hn::Sub(of_log_n, mean);
  for (int64_t s = 0; s < shape.samples; ++s)
    for (int64_t k = l; k < behind(shape, l); ++k) {
      float* to = scratch.gradient.row(s * shape.layers + k) + x;
      const V pull =
          k == l ? hn::Load(d, scratch.gradient.row(shape.samples * shape.layers + s) + x) : of_transmittance;
      hn::Store(hn::MulAdd(share_of(d, shape, n, s, k, x), hn::Add(pull, offset), hn::Load(d, to)), d, to);
    }
}

/// Embedding of one sample: its gradient, and its pull on the weights. Channel by channel, so that each plane
/// is read along its row.
HWY_INLINE void embedding_backward(D d, const Tile& tile, const PartitionInput& in,
                                   const PartitionGradient& from, const PartitionInputGradient& to, int64_t s,
                                   PartitionScratch& scratch) {
  const int64_t layers = tile.shape.layers, channels = tile.shape.embedding;
  for (int64_t l = 0; l < layers; ++l) std::fill_n(scratch.pull.row(l), kPartitionPixels, 0.0f);
  for (int64_t c = 0; c < channels; ++c)
    tile.each([&](int64_t x, int64_t left) {
      const V value = hn::And(load(d, in.embedding.plane(s * channels + c) + x, left),
                              hn::Load(d, scratch.mask.row(s) + x));
      V sum = hn::Zero(d);
      for (int64_t l = 0; l < layers; ++l) {
        const V g = load(d, from.embedding.plane(l * channels + c) + x, left);
        float* pull = scratch.pull.row(l) + x;
        hn::Store(hn::MulAdd(g, value, hn::Load(d, pull)), d, pull);
        sum = hn::MulAdd(hn::Load(d, scratch.weight.row(s * layers + l) + x), g, sum);
      }
      if (to.embedding.data != nullptr) store(d, sum, to.embedding.plane(s * channels + c) + x, left);
    });
  tile.each([&](int64_t x, int64_t) {
    for (int64_t l = 0; l < layers; ++l) {
      float* gradient = scratch.gradient.row(s * layers + l) + x;
      hn::Store(hn::MulAdd(hn::Load(d, scratch.weight.row(s * layers + l) + x),
                           hn::Load(d, scratch.pull.row(l) + x), hn::Load(d, gradient)),
                d, gradient);
    }
  });
}

void tile_backward(const PartitionShape& shape, const PartitionInput& in, const PartitionGradient& from,
                   const PartitionInputGradient& to, int64_t count, PartitionScratch& scratch) {
  const D d;
  const Tile tile{shape, count};
  const int64_t layers = shape.layers;
  tile.each([&](int64_t x, int64_t left) {
    const V samples = count_samples(d, tile, in, x, left, scratch);
    const V inverse_count =
        hn::IfThenElseZero(hn::Gt(samples, hn::Zero(d)), hn::Div(hn::Set(d, 1.0f), samples));
    weights(d, tile, in, x, left, inverse_count, scratch);
    for (int64_t k = 0; k < shape.samples * layers; ++k)
      hn::Store(hn::Zero(d), d, scratch.gradient.row(k) + x);
    for (int64_t l = 0; l < layers; ++l) layer_backward(d, tile, in, from, l, x, left, scratch);
  });
  for (int64_t s = 0; s < shape.samples; ++s) {
    if (from.embedding.data != nullptr) {
      embedding_backward(d, tile, in, from, to, s, scratch);
    } else if (to.embedding.data != nullptr) {
      for (int64_t c = 0; c < shape.embedding; ++c)
        std::fill_n(to.embedding.plane(s * shape.embedding + c), count, 0.0f);
    }
  }
  tile.each([&](int64_t x, int64_t left) {
    for (int64_t s = 0; s < shape.samples; ++s) {
      V total = hn::Zero(d);
      for (int64_t l = 0; l < layers; ++l)
        total = hn::Add(total, hn::Load(d, scratch.gradient.row(s * layers + l) + x));
      for (int64_t l = 0; l < layers; ++l) {
        // Back through the log-softmax of eq. 1; a sample that does not count has gradients and w of 0.
        const V w = exp_negative(d, hn::Load(d, scratch.log_w.row(s * layers + l) + x));
        const V gradient = hn::NegMulAdd(w, total, hn::Load(d, scratch.gradient.row(s * layers + l) + x));
        store(d, gradient, to.logits.plane(s * layers + l) + x, left);
      }
      if (to.radiance.data == nullptr) continue;
      for (int64_t c = 0; c < shape.channels; ++c) {
        V sum = hn::Zero(d);
        for (int64_t l = 0; l < layers; ++l)
          sum = hn::MulAdd(hn::Load(d, scratch.share.row(s * layers + l) + x),
                           load_gradient(d, from.radiance, shape.channels * l + c, x, left), sum);
        store(d, sum, to.radiance.plane(shape.channels * s + c) + x, left);
      }
    }
  });
}

}  // namespace HWY_NAMESPACE
}  // namespace ld
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace ld {

PartitionScratch::PartitionScratch(const PartitionShape& shape)
    : log_w(shape.samples * shape.layers, kPartitionPixels, 0, 0.0f),
      share(shape.samples * shape.layers, kPartitionPixels, 0, 0.0f),
      weight(shape.samples * shape.layers, kPartitionPixels, 0, 0.0f),
      term(shape.samples * shape.layers, kPartitionPixels, 0, 0.0f),
      gradient(shape.samples * (shape.layers + 1), kPartitionPixels, 0, 0.0f),
      pull(shape.layers, kPartitionPixels, 0, 0.0f),
      mask(shape.samples, kPartitionPixels, 0, 0.0f) {}

HWY_EXPORT(tile_forward);
HWY_EXPORT(tile_backward);

void partition_tile(const PartitionShape& shape, const PartitionInput& in, const PartitionOutput& out,
                    int64_t count, PartitionScratch& scratch) {
  HWY_DYNAMIC_DISPATCH(tile_forward)(shape, in, out, count, scratch);
}

void partition_tile_backward(const PartitionShape& shape, const PartitionInput& in,
                             const PartitionGradient& from, const PartitionInputGradient& to, int64_t count,
                             PartitionScratch& scratch) {
  HWY_DYNAMIC_DISPATCH(tile_backward)(shape, in, from, to, count, scratch);
}

}  // namespace ld
#endif
