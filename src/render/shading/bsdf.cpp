#include "render/shading/bsdf.h"

#include "render/geometry/sampling.h"
#include "render/shading/coated_bsdf.h"
#include "render/shading/microfacet.h"

namespace ld {
namespace {

Vec3 reflect(Vec3 w, Vec3 m) {
  return m * (2 * dot(w, m)) - w;
}

BsdfValue evaluate_rough_dielectric(const Bsdf& bsdf, Vec3 wo, Vec3 wi) {
  if (wi.z == 0) return {};
  const bool reflected = wi.z > 0;
  Vec3 m = reflected ? wo + wi : wo + wi * bsdf.eta;  // eq. 13 and 16
  const float m_length = length(m);
  if (m_length < 1e-6F) return {};  // equal indices: nothing bends, no single normal explains it
  m = m / (m.z < 0 ? -m_length : m_length);
  const float cos_o = dot(wo, m), cos_i = dot(wi, m);
  if (cos_o <= 0 || (reflected ? cos_i <= 0 : cos_i >= 0)) return {};
  const float visible = ggx_visible_pdf(wo, m, bsdf.alpha);
  const float fresnel = fresnel_dielectric(cos_o, bsdf.eta);
  const float masking = ggx_masking(wi, bsdf.alpha);
  if (reflected) {
    const float pdf = fresnel * visible / (4 * cos_o);  // eq. 14
    return {grey(masking * pdf), pdf};
  }
  const float denominator = cos_o + bsdf.eta * cos_i;
  const float pdf =
      (1 - fresnel) * visible * bsdf.eta * bsdf.eta * -cos_i / (denominator * denominator);  // eq. 17
  return {bsdf.colour * (masking * pdf / (bsdf.eta * bsdf.eta)), pdf};
}

std::optional<BsdfSample> sample_dielectric(const Bsdf& bsdf, Vec3 wo, Vec3 m, float choice) {
  const float cos_o = dot(wo, m);
  if (cos_o <= 0) return std::nullopt;
  float cos_t = 0;
  const float fresnel = fresnel_dielectric(cos_o, bsdf.eta, &cos_t);
  const float inverse_eta = 1 / bsdf.eta;
  if (choice < fresnel) return BsdfSample{reflect(wo, m), grey(1), 0, true};
  const Vec3 wi = m * (cos_o * inverse_eta - cos_t) - wo * inverse_eta;
  return BsdfSample{wi, bsdf.colour * (inverse_eta * inverse_eta), 0, true};
}

}  // namespace

void Bsdf::regularise(float least_alpha) {
  constexpr float kNoInterface = 0.01F;
  switch (kind) {
    case MaterialKind::mirror:
      alpha = least_alpha;  // Scene files may give a mirror any roughness; it means nothing.
      rough_mirror = true;
      break;
    case MaterialKind::smooth_dielectric:
      if (std::abs(eta - 1) < kNoInterface) break;
      alpha = least_alpha;
      kind = MaterialKind::rough_dielectric;
      break;
    case MaterialKind::coated_metal:
      base_alpha = std::max(base_alpha, least_alpha);
      [[fallthrough]];
    case MaterialKind::rough_conductor:
    case MaterialKind::rough_dielectric:
    case MaterialKind::plastic:
      alpha = std::max(alpha, least_alpha);
      break;
    case MaterialKind::diffuse:
    case MaterialKind::mixed:
      break;
  }
}

Vec3 Bsdf::conductor_fresnel(float cos_i) const {
  if (is_black(metal_k)) return kind == MaterialKind::mirror ? colour : fresnel_schlick(colour, cos_i);
  return {fresnel_conductor(cos_i, metal_eta.x, metal_k.x), fresnel_conductor(cos_i, metal_eta.y, metal_k.y),
          fresnel_conductor(cos_i, metal_eta.z, metal_k.z)};
}

BsdfValue evaluate_conductor(const Bsdf& bsdf, float alpha, Vec3 wo, Vec3 wi) {
  if (wi.z <= 0) return {};
  const Vec3 m = normalize(wo + wi);
  const float cos_m = dot(wo, m);
  const float visible = ggx_visible_pdf(wo, m, alpha);
  const float pdf = visible / (4 * cos_m);
  // f cos = F G1(wo) G1(wi) D / (4 cos wo) is the density times F G1(wi).
  return {bsdf.conductor_fresnel(cos_m) * (ggx_masking(wi, alpha) * pdf), pdf};
}

std::optional<BsdfSample> sample_conductor(const Bsdf& bsdf, float alpha, Vec3 wo, float u1, float u2) {
  const Vec3 wi = reflect(wo, sample_ggx_visible_normal(wo, alpha, u1, u2));
  if (wi.z <= 0) return std::nullopt;
  const BsdfValue value = evaluate_conductor(bsdf, alpha, wo, wi);
  if (!(value.pdf > 0)) return std::nullopt;
  return BsdfSample{wi, value.f_cos / value.pdf, value.pdf, false};
}

BsdfValue Bsdf::evaluate(Vec3 wo, Vec3 wi) const {
  switch (kind) {
    case MaterialKind::diffuse:
      if (wi.z <= 0) return {};
      return {colour * (wi.z / kPi), wi.z / kPi};
    case MaterialKind::rough_conductor:
      return evaluate_conductor(*this, alpha, wo, wi);
    case MaterialKind::rough_dielectric:
      return evaluate_rough_dielectric(*this, wo, wi);
    case MaterialKind::plastic:
    case MaterialKind::coated_metal:
      return evaluate_coated(*this, wo, wi);
    case MaterialKind::mirror:
      if (rough_mirror) return evaluate_conductor(*this, alpha, wo, wi);
      break;
    case MaterialKind::smooth_dielectric:
    case MaterialKind::mixed:
      break;
  }
  return {};
}

std::optional<BsdfSample> Bsdf::sample(Vec3 wo, float u0, float u1, float u2) const {
  switch (kind) {
    case MaterialKind::diffuse: {
      const Vec3 wi = sample_cosine_hemisphere(u1, u2);
      if (wi.z <= 0) return std::nullopt;
      return BsdfSample{wi, colour, wi.z / kPi, false};
    }
    case MaterialKind::mirror:
      if (rough_mirror) return sample_conductor(*this, alpha, wo, u1, u2);
      return BsdfSample{{-wo.x, -wo.y, wo.z}, conductor_fresnel(wo.z), 0, true};
    case MaterialKind::smooth_dielectric:
      return sample_dielectric(*this, wo, {0, 0, 1}, u0);
    case MaterialKind::rough_conductor:
      return sample_conductor(*this, alpha, wo, u1, u2);
    case MaterialKind::plastic:
    case MaterialKind::coated_metal:
      return sample_coated(*this, wo, u0, u1, u2);
    case MaterialKind::mixed:
      break;
    case MaterialKind::rough_dielectric: {
      const Vec3 m = sample_ggx_visible_normal(wo, alpha, u1, u2);
      std::optional<BsdfSample> drawn = sample_dielectric(*this, wo, m, u0);
      if (!drawn) return std::nullopt;
      const BsdfValue value = evaluate_rough_dielectric(*this, wo, drawn->wi);
      // A reflected direction below the surface, or a refracted one above it, has no density of its own kind.
      if (!(value.pdf > 0)) return std::nullopt;
      const bool reflected = dot(drawn->wi, m) > 0;
      if (reflected != (drawn->wi.z > 0)) return std::nullopt;
      return BsdfSample{drawn->wi, value.f_cos / value.pdf, value.pdf, false};
    }
  }
  return std::nullopt;
}

}  // namespace ld
