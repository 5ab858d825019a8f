// GGX microfacets and Fresnel terms (Walter et al., "Microfacet models for refraction through rough
// surfaces", EGSR 2007). Directions are unit vectors in a local frame whose +z is the macroscopic normal;
// alpha is Walter's alpha_g.
#pragma once

#include "render/geometry/sampling.h"

namespace ld {

/// D(m), eq. 33; 0 below the surface.
inline float ggx_distribution(Vec3 m, float alpha) {
  if (m.z <= 0) return 0;
  const float a2 = alpha * alpha;
  const float d = a2 * m.z * m.z + m.x * m.x + m.y * m.y;
  return a2 / (kPi * d * d);
}

/// Smith masking G1, eq. 34; even in w.z.
inline float ggx_masking(Vec3 w, float alpha) {
  const float cos2 = w.z * w.z;
  if (cos2 == 0) return 0;
  return 2 / (1 + std::sqrt(1 + alpha * alpha * (w.x * w.x + w.y * w.y) / cos2));
}

/// Density of sample_ggx_visible_normal over the solid angle of m; w.z > 0.
inline float ggx_visible_pdf(Vec3 w, Vec3 m, float alpha) {
  return ggx_masking(w, alpha) * std::max(0.0F, dot(w, m)) * ggx_distribution(m, alpha) / w.z;
}

/// A normal as seen from w (w.z > 0): Heitz, "Sampling the GGX distribution of visible normals", JCGT 2018.
inline Vec3 sample_ggx_visible_normal(Vec3 w, float alpha, float u, float v) {
  const Vec3 v_h = normalize(Vec3{alpha * w.x, alpha * w.y, w.z});
  const float horizontal = std::sqrt(v_h.x * v_h.x + v_h.y * v_h.y);
  const Vec3 t1 = horizontal > 0 ? Vec3{-v_h.y / horizontal, v_h.x / horizontal, 0} : Vec3{1, 0, 0};
  const Vec3 t2 = cross(v_h, t1);
  const Vec2 disk = sample_disk(u, v);
  const float s = 0.5F * (1 + v_h.z);
  const float p1 = disk.x;
  const float p2 = (1 - s) * std::sqrt(std::max(0.0F, 1 - p1 * p1)) + s * disk.y;
  const Vec3 n = t1 * p1 + t2 * p2 + v_h * std::sqrt(std::max(0.0F, 1 - p1 * p1 - p2 * p2));
  return normalize(Vec3{alpha * n.x, alpha * n.y, std::max(1e-6F, n.z)});
}

/// Unpolarised reflectance of a dielectric; cos_i > 0 on the incident side, eta = index behind / index in
/// front. 1 under total internal reflection. `cos_t`, when given, receives the cosine of refraction.
inline float fresnel_dielectric(float cos_i, float eta, float* cos_t = nullptr) {
  const float sin2_t = (1 - cos_i * cos_i) / (eta * eta);
  if (sin2_t >= 1) return 1;
  const float ct = std::sqrt(1 - sin2_t);
  if (cos_t != nullptr) *cos_t = ct;
  const float parallel = (eta * cos_i - ct) / (eta * cos_i + ct);
  const float perpendicular = (cos_i - eta * ct) / (cos_i + eta * ct);
  return 0.5F * (parallel * parallel + perpendicular * perpendicular);
}

/// Unpolarised reflectance of a conductor of complex index eta + i k seen from air, exact (Born and Wolf,
/// "Principles of optics", section 14.2).
inline float fresnel_conductor(float cos_i, float eta, float k) {
  const float c2 = cos_i * cos_i, s2 = 1 - c2;
  const float difference = eta * eta - k * k - s2;
  const float a2_plus_b2 = std::sqrt(difference * difference + 4 * eta * eta * k * k);
  const float a = std::sqrt(std::max(0.0F, 0.5F * (a2_plus_b2 + difference)));
  const float perpendicular = (a2_plus_b2 + c2 - 2 * a * cos_i) / (a2_plus_b2 + c2 + 2 * a * cos_i);
  const float t = a2_plus_b2 * c2 + s2 * s2, u = 2 * a * cos_i * s2;
  const float parallel = perpendicular * (t - u) / (t + u);
  return 0.5F * (perpendicular + parallel);
}

/// Schlick 1994, for conductors given by their colour at normal incidence.
inline Vec3 fresnel_schlick(Vec3 f0, float cos_i) {
  const float c = std::clamp(1 - cos_i, 0.0F, 1.0F);
  const float c5 = c * c * c * c * c;
  return f0 + (grey(1) - f0) * c5;
}

}  // namespace ld
