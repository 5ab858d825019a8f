// Light apart from the colour of the surface that sends it on: S = (C - E) / A.
#pragma once

#include <array>

#include "filters/kernels/row_planes.h"
#include "filters/kernels/surfaces.h"
#include "filters/settings.h"

namespace ld {

/// A pixel's radiance is C = S A + E. E is what the camera sees by itself: light of the first hit, and all
/// light where no surface is. A = max(albedo + specular, kLeastAlbedo) a channel, so that dividing and
/// multiplying are each other's inverse.
struct Illumination {
  RowPlanes albedo;    // A, three planes
  RowPlanes emission;  // E, three planes
  RowPlanes signals;   // S, three planes each: direct and indirect light, or both in one
};

constexpr float kLeastAlbedo = 1e-3F;  // as in the public implementations of SVGF
/// Larger signals count as this: their sums and products stay finite.
constexpr float kLargestSignal = 1e37F;

/// Range compression of the signals (IlluminationSettings::compress): R(c) = c / (1 + c) for c >= 0, and its
/// inverse c / max(1 - c, 1e-4), exact below 1e4.
void compress(RowPlanes& signals, int threads);
void expand(RowPlanes& signals, int threads);

/// Scales each pixel's signal so that its luminance is at most `bound` times the mean of the eight pixels
/// around it; `spare` receives the result and is swapped with `signals`.
void bound_fireflies(RowPlanes& signals, RowPlanes& spare, double bound, int threads);

/// Three planes: the sum of the filtered signals, times A, plus E, at most kLargestSignal. `filtered` has
/// `planes` planes a signal, of which the first three are its colour.
void recombine(const RowPlanes& filtered, int planes, const Illumination& light, bool is_compressed,
               RowPlanes& out, int threads);

/// [3, H, W]
Image image_of(const RowPlanes& picture, int threads);

}  // namespace ld
