// The operators of a graph. Each says what it reads, what it makes and whose equation it is; shapes are
// [items, channels], the two sides of the picture left out. Weights are named by the parameters of the
// network's modules.
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "core/activation.h"

namespace ld::graph {

/// The frame -> encoded features [S, F], radiance [S, 3] and behind it Graph::parts, valid [S, 1]
/// (frame/encoding.h). Of features, the radiance is exposed where Graph::exposed says so.
struct Encode {
  std::vector<std::string> features;
};

/// x [n, C], valid [n, 1] -> the mean over the items that are valid [1, C]; 0 where a pixel has none.
struct MaskedMean {};

/// valid [n, 1] -> [1, 1]: 1 where any item is.
struct AnyValid {};

/// valid [n, 1] -> [n, 1]: 0, or -inf for an item that is not valid.
struct LogValid {};

/// x [n, C], valid [n, 1] -> x, in which items that are not valid have those of the pixel's first valid one
/// (models/networks/sample_splat_network.h).
struct FirstValid {};

/// x [n, C], valid [n, 1] -> mean and population variance of each channel [1, 2 C], means first, in two
/// passes (models/sample_statistics.h).
struct Statistics {};

/// x [1, C], radiance [1, 3], valid [1, 1] -> x with the tone-mapped radiance from channel `first` on,
/// exposed where Graph::exposed says so; 0 where not valid (models/pixel_mean.h).
struct ToneMapped {
  int64_t first = 0;
};

/// x [n, X] and, where there is a second input, context [1, Y] -> [n, outputs], or [1, outputs] of the first
/// item alone: layers of leaky ReLU (ops/fully_connected.h). Parameters: <weights>.<layer>.weight and .bias;
/// of the last layer's, those from `first_output` on.
struct FullyConnected {
  std::string weights;
  std::vector<int64_t> widths;  // outputs of its layers
  bool activate_last = false;
  double bound = 0;
  int64_t first_output = 0;
};

/// [1, C] -> the same, its last row and column repeated to the padded sides.
struct Pad {};

/// 3x3, zeros beyond the padded border (models/unet.h). All inputs have one size: their channels follow one
/// another.
struct Convolution {
  std::string weights;
  double slope = 1;  // below 0, of the leaky ReLU behind it; 1: none
};

/// kernel x kernel, 3 or 5, the pixels at the border repeated beyond it (models/edge_convolution.h). Inputs
/// as Convolution's.
struct EdgeConvolution {
  std::string weights;
  int64_t kernel = 3;
  Activation activation = Activation::none;
};

/// 2x2, to the next level.
struct MaxPool {};

/// 2^levels times the sides, from so many levels on; the last rows and columns are left out where the result
/// has fewer.
struct Upsample {
  bool bilinear = true;
  int levels = 1;
};

/// log n [N, 1], pixels [1, 1], embedding [N, E] and values [N, ...] one behind the other -> the same at the
/// next level: four pixels become one. `pixels` is how many pixels of full resolution with samples lie in
/// each (models/networks/layer_pyramid.h).
struct Halve {};

/// pixels [1, 1] -> [1, 1]: 1 where a kernel of so many taps a side reaches from a pixel with samples, else
/// 0.
struct Received {
  int64_t kernel = 1;
};

/// logits [1, L], then of each level its picture [1, C] and what it received [1, 1], both scaled up -> [1,
/// C]: a softmax over the levels that have something to say ([MH20] eq. 10;
/// models/level_blend.h).
struct BlendLevels {};

/// [1, C] -> [1, 4 C] at the next level, and back again, rows and columns that an odd side lacks repeated and
/// left out (models/super_resolution.h).
struct SpaceToDepth {};
struct DepthToSpace {};

/// light [1, 3], drawn [1, 1] and, with demodulation, reflectance [1, 3] -> at the next level, of the mean
/// over those of 2x2 pixels that are drawn: tone-mapped light [1, 3], without its reflectance where that is
/// given, 1 where it is known [1, 1], and that reflectance [1, 3], 1 where it is not known. `mapped`: the
/// light comes tone mapped (models/networks/espcn_kpcn_network.cpp).
struct HalveLight {
  bool mapped = false;
};

/// Tone-mapped light [1, 3] and, with demodulation, reflectance [1, 3], drawn [1, 1], and the reflectance
/// that counts where nothing is drawn [1, 3] -> linear radiance [1, 3].
struct Relight {};

/// [n, C] -> its channels from `first` on, as many as the result has.
struct Channels {
  int64_t first = 0;
};

/// x [n, C], y [n, C] -> x + y.
struct Add {};

/// features [S, F], radiance [S, 3], valid [S, 1] -> both forms of the radiance [S, 6] and what
/// ModulationFactors needs [1, 4] (models/demodulation.h). First channels of the features that are there,
/// else -1. Behind the radiance's come both forms of all coloured parts, the divided ones first, then alpha
/// as it is.
struct Demodulate {
  int64_t albedo = -1, specular = -1;
};

/// features [S, F], valid [S, 1] -> what radiance is divided by, the mean over the samples that are valid [1,
/// 3]; 0 where a pixel has none. Channels as Demodulate's.
struct Reflectance {
  int64_t albedo = -1, specular = -1;
};

/// logits [S, N], valid [S, 1], radiance [S, C], embedding [S, E] -> log n [N, 1], radiance [N, C], opacity
/// [N, 1], embedding [N, E] and, with alpha, transmittance [N, 1] (ops/partition.h; [MH20] eq. 1 and 2).
struct Partition {
  bool alpha = true;
};

/// log n [n, 1], embedding [n, E], context [1, C] -> log n [n, 1] (models/rejection.h).
struct Reject {
  std::string weights;
};

/// embedding [n, E], context [1, Y], log n [n, 1] and values [n, ...] one behind the other -> [n or 1,
/// channels]: each pixel's light scattered with a kernel from the generator ([MH20] eq. 3 and 4;
/// ops/generated_filter.h).
struct Splat {
  FullyConnected generator;
  int64_t kernel = 1;
  bool joint = false;  // over all layers, to one result
  int64_t rows = 32;   // of sources that are added up before they meet others': fixed, so that bits are
};

/// embedding [1, E], context [1, Y], log n [1, 1], values [1, C] -> [1, C]: what each pixel receives from its
/// neighbours (ops/kernel_gather.h).
struct Gather {
  FullyConnected generator;
  int64_t kernel = 1;
};

/// logits [1, K*K], log n [1, 1], values [1, C] -> [1, C]: the same with logits that are there already,
/// within a bound as FullyConnected's.
struct GatherTaps {
  int64_t kernel = 1;
  double bound = 0;
};

/// log n [1, 1], values [1, C] -> [1, C]: the mean of the neighbours under a Gaussian of `kernel` taps a
/// side, whose deviation is a sixth of that (models/networks/pixel_blend_network.cpp).
struct Blur {
  int64_t kernel = 1;

  /// Of each tap, row by row: -d^2 / (2 sigma^2).
  std::vector<double> logits() const {
    std::vector<double> all;
    const int64_t radius = kernel / 2;
    for (int64_t dy = -radius; dy <= radius; ++dy)
      for (int64_t dx = -radius; dx <= radius; ++dx)
        all.push_back(-18.0 * double(dy * dy + dx * dx) / double(kernel * kernel));
    return all;
  }
};

/// logit [1, 1], valid [1, 1], x [1, C], y [1, C] -> k x + (1 - k) y with k = sigmoid(logit), 0 where not
/// valid.
struct Mix {};

/// [N, C + 1], the transmittance last -> [1, C] ([MH20] eq. 5; models/compositor.h).
struct Composite {};

/// modulators [1, 4], context [1, C] -> A [1, 3] and beta [1, 1], in one value (models/demodulation.h).
struct ModulationFactors {
  std::string weights;
};

/// filtered [1, 6], factors [1, 4] -> [1, 3] (models/demodulation.h).
struct Modulate {};

/// features [S, F], valid [S, 1] -> the light that the frame before has left, where its surfaces are now [1,
/// C], how many frames it counts for [1, 1], 0 where there is none, and the surface of this frame's pixels
/// [1, 4] (models/history.h). First channels of the features that are there, else -1.
struct Recall {
  int64_t flow = -1, depth = -1, normal = -1;
};

/// light [1, C], past [1, C], frames [1, 1] -> how far the first three channels differ [1, 3]
/// (models/history.h), over the pixels within `radius`.
struct Compare {
  int64_t radius = 0;
};

/// logit [1, 1], light [1, C], past [1, C], frames [1, 1], drawn [1, 1] -> the light with its history [1, C],
/// and how many frames it counts for [1, 1] (models/history.h).
struct Remember {};

/// features [S, F], radiance [S, 3], valid [S, 1] -> what a recurrent autoencoder sees [1, 7], texture [1, 3]
/// and emission [1, 3] (models/recurrent.h). First channels of the features that are there, else -1.
struct TakeRoots {
  int64_t normal = -1, depth = -1, roughness = -1, albedo = -1, specular = -1, emission = -1;
};

/// predicted [1, 3], texture [1, 3], emission [1, 3] -> the picture [1, 3] (models/recurrent.h).
struct RaiseRoots {};

/// -> [1, C]: what the frame before has left as this part of Graph::state, within +-65504; zeros where
/// nothing comes before.
struct RecallPart {
  int64_t part = 0;  // -1: zeros always
};

/// -> [N, N]: item l is 1 in channel l, else 0; whose splat tells how much of a pixel comes from layer l.
struct LayerIdentity {};

using Operator =
    std::variant<Encode, MaskedMean, AnyValid, LogValid, FirstValid, Statistics, ToneMapped, FullyConnected,
                 Pad, Convolution, EdgeConvolution, MaxPool, Upsample, SpaceToDepth, DepthToSpace, HalveLight,
                 Relight, Channels, Add, Halve, Received, BlendLevels, Demodulate, Reflectance, Partition,
                 Reject, Splat, Gather, GatherTaps, Blur, Mix, Composite, ModulationFactors, Modulate, Recall,
                 Compare, Remember, TakeRoots, RaiseRoots, RecallPart, LayerIdentity>;

/// Whether each pixel is made from the same pixel of the inputs alone.
bool is_pixelwise(const Operator& op);

/// Rows of an input that an operator reads for its rows [begin, end): up to rows_read_to(end), and of the
/// rows before rows_read_from(begin) none any more once all rows before `begin` are made. Both within [0,
/// height], the input's.
int64_t rows_read_to(const Operator& op, int64_t end, int64_t height);
int64_t rows_read_from(const Operator& op, int64_t begin, int64_t height);

/// Pixels of a row or of a column, [begin, end).
struct Span {
  int64_t begin = 0, end = 0;
  bool empty() const { return begin >= end; }
  bool meets(int64_t first, int64_t count) const { return first < end && begin < first + count; }
};

/// Which of an input's pixels, on either axis, of which there are `size`, an operator makes those of its
/// result from that lie in `made`; in whole pairs for those that make pairs.
Span pixels_read(const Operator& op, Span made, int64_t size);

}  // namespace ld::graph
