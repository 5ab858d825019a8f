// The surface scattering functions at one point. Directions are local: +z is the shading normal on the
// viewer's side (wo.z > 0), wo points to the viewer, wi to the light; both leave the surface.
#pragma once

#include <optional>

#include "render/vec3.h"

namespace ld {

enum class MaterialKind { diffuse, rough_conductor, mirror, smooth_dielectric, rough_dielectric };

struct BsdfValue {
  Vec3 f_cos;     // f(wo, wi) |cos wi|, 1/sr times cosine
  float pdf = 0;  // density of sample() over the solid angle of wi, 1/sr
};

struct BsdfSample {
  Vec3 wi;
  Vec3 weight;         // f |cos| / pdf
  float pdf = 0;       // 0 for a delta direction
  bool delta = false;  // mirror, smooth dielectric: evaluate() is 0 everywhere
};

/// diffuse: f = colour / pi.
/// rough_conductor: Torrance-Sparrow with GGX and Smith's separable masking (Walter et al. 2007, eq. 20),
/// Fresnel by
///   Schlick with `colour` at normal incidence.
/// mirror: reflects `colour`, whatever the angle.
/// smooth_dielectric, rough_dielectric: exact Fresnel; what is transmitted is multiplied by `colour` and, as
/// radiance
///   is transported, by 1 / eta^2 (Walter et al. 2007, eq. 20 and 21).
struct Bsdf {
  MaterialKind kind = MaterialKind::diffuse;
  Vec3 colour = {0.5F, 0.5F, 0.5F};
  float alpha = 1;  // of GGX
  float eta = 1;    // index behind the surface over index on the viewer's side

  bool is_delta() const { return kind == MaterialKind::mirror || kind == MaterialKind::smooth_dielectric; }

  /// Both zero for delta kinds and where nothing scatters.
  BsdfValue evaluate(Vec3 wo, Vec3 wi) const;

  /// Draws wi from three uniform numbers. Empty when the draw left the hemisphere: its energy is lost, as in
  /// any single-scattering microfacet model.
  std::optional<BsdfSample> sample(Vec3 wo, float u0, float u1, float u2) const;
};

}  // namespace ld
