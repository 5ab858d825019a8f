// The surface scattering functions at one point. Directions are local: +z is the shading normal on the
// viewer's side (wo.z > 0), wo points to the viewer, wi to the light; both leave the surface.
#pragma once

#include <optional>

#include "render/geometry/vec3.h"

namespace ld {

enum class MaterialKind {
  diffuse,
  rough_conductor,
  mirror,
  smooth_dielectric,
  rough_dielectric,
  plastic,       // a clear coat over a diffuse base
  coated_metal,  // a clear coat over a rough conductor
  mixed          // one of two materials for each sample; never reaches a Bsdf
};

constexpr float kSmallestAlpha = 1e-3F;  // below it GGX's peak is beyond what float directions resolve

struct BsdfValue {
  Vec3 f_cos;     // f(wo, wi) |cos wi|, 1/sr times cosine; without what scatters in delta directions
  float pdf = 0;  // density of sample() over the solid angle of wi, 1/sr; likewise
};

struct BsdfSample {
  Vec3 wi;
  Vec3 weight;         // f |cos| / pdf
  float pdf = 0;       // 0 for a delta direction
  bool delta = false;  // mirror, smooth dielectric, smooth coat: evaluate() does not have it
};

/// diffuse: f = colour / pi.
/// rough_conductor: Torrance-Sparrow with GGX and Smith's separable masking (Walter et al. 2007, eq. 20),
///   Fresnel exact from the metal's complex index, or by Schlick with `colour` at normal incidence.
/// mirror: reflects `colour` whatever the angle, or by the metal's Fresnel term.
/// smooth_dielectric, rough_dielectric: exact Fresnel; what is transmitted is multiplied by `colour` and, as
///   radiance is transported, by 1 / eta^2 (Walter et al. 2007, eq. 20 and 21).
/// plastic, coated_metal: a dielectric GGX coat of directional albedo E over a base. The diffuse base is
///   (1 - E(wo)) (1 - E(wi)) colour / (pi (1 - mean E)), so that a white one loses nothing (Kulla and Conty
///   2017; with a smooth coat it is Mitsuba's `plastic`); the metal is seen through the coat as
///   (1 - E(wo)) (1 - E(wi)) f. Both are reciprocal.
struct Bsdf {
  MaterialKind kind = MaterialKind::diffuse;
  Vec3 colour = {0.5F, 0.5F, 0.5F};
  float alpha = 1;       // of GGX; of a coat, 0 smooth
  float eta = 1;         // index behind the surface over index on the viewer's side; of a coat: its index
  float base_alpha = 1;  // of the metal under a coat
  // Complex index of conductors; used where k is not black.
  Vec3 metal_eta = {}, metal_k = {};
  bool rough_mirror = false;  // a mirror that regularise() gave `alpha`: its reflectance stays a mirror's

  /// All of it scatters into delta directions.
  bool is_delta() const {
    return (kind == MaterialKind::mirror && !rough_mirror) || kind == MaterialKind::smooth_dielectric;
  }

  /// Raises the GGX alpha of every lobe to at least `least_alpha`, in (0, 1]; mirrors, smooth dielectrics and
  /// smooth coats become rough. Diffuse lobes stay, and so does a dielectric that hardly bends light (indices
  /// within 1 %): there no microfacet explains what passes straight on.
  void regularise(float least_alpha);

  /// Both zero for delta kinds and where nothing scatters.
  BsdfValue evaluate(Vec3 wo, Vec3 wi) const;

  /// Draws wi from three uniform numbers. Empty when the draw left the hemisphere: its energy is lost, as in
  /// any single-scattering microfacet model.
  std::optional<BsdfSample> sample(Vec3 wo, float u0, float u1, float u2) const;

  /// Reflectance of a conductor or mirror at this cosine.
  Vec3 conductor_fresnel(float cos_i) const;
};

}  // namespace ld
