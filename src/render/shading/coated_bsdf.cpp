#include "render/shading/coated_bsdf.h"

#include "render/shading/coat.h"
#include "render/shading/microfacet.h"

namespace ld {
namespace {

/// Probability of sampling the coat: about its share of the reflected light, neither ever starved.
float coat_probability(const Bsdf& bsdf, float coat) {
  const float base = (1 - coat) * (bsdf.kind == MaterialKind::plastic ? max_component(bsdf.colour) : 0.9F);
  return std::clamp(coat / std::max(coat + base, 1e-6F), 0.1F, 0.9F);
}

BsdfValue evaluate_base(const Bsdf& bsdf, const CoatAlbedo& coat, float coat_wo, Vec3 wo, Vec3 wi) {
  const float through = (1 - coat_wo) * (1 - coat.towards(wi.z));
  if (bsdf.kind == MaterialKind::plastic) {
    const float pdf = wi.z / kPi;
    return {bsdf.colour * (through * pdf / (1 - coat.average())), pdf};
  }
  const BsdfValue metal = evaluate_conductor(bsdf, bsdf.base_alpha, wo, wi);
  return {metal.f_cos * through, metal.pdf};
}

BsdfValue evaluate_rough_coat(const Bsdf& bsdf, Vec3 wo, Vec3 wi) {
  const Vec3 m = normalize(wo + wi);
  const float cos_m = dot(wo, m);
  const float pdf = ggx_visible_pdf(wo, m, bsdf.alpha) / (4 * cos_m);
  return {grey(fresnel_dielectric(cos_m, bsdf.eta) * ggx_masking(wi, bsdf.alpha) * pdf), pdf};
}

BsdfValue evaluate_with(const Bsdf& bsdf, const CoatAlbedo& coat, float coat_wo, Vec3 wo, Vec3 wi) {
  if (wi.z <= 0) return {};
  const float p = coat_probability(bsdf, coat_wo);
  BsdfValue value = evaluate_base(bsdf, coat, coat_wo, wo, wi);
  value.pdf *= 1 - p;
  if (bsdf.alpha == 0) return value;  // the smooth coat's reflection is a delta direction
  const BsdfValue top = evaluate_rough_coat(bsdf, wo, wi);
  return {value.f_cos + top.f_cos, value.pdf + p * top.pdf};
}

}  // namespace

BsdfValue evaluate_coated(const Bsdf& bsdf, Vec3 wo, Vec3 wi) {
  const CoatAlbedo coat(bsdf.alpha, bsdf.eta);
  return evaluate_with(bsdf, coat, coat.towards(wo.z), wo, wi);
}

std::optional<BsdfSample> sample_coated(const Bsdf& bsdf, Vec3 wo, float u0, float u1, float u2) {
  const CoatAlbedo coat(bsdf.alpha, bsdf.eta);
  const float coat_wo = coat.towards(wo.z);
  const float p = coat_probability(bsdf, coat_wo);
  Vec3 wi;
  if (u0 < p) {
    if (bsdf.alpha == 0)
      return BsdfSample{{-wo.x, -wo.y, wo.z}, grey(fresnel_dielectric(wo.z, bsdf.eta) / p), 0, true};
    const Vec3 m = sample_ggx_visible_normal(wo, bsdf.alpha, u1, u2);
    wi = m * (2 * dot(wo, m)) - wo;
  } else if (bsdf.kind == MaterialKind::plastic) {
    wi = sample_cosine_hemisphere(u1, u2);
  } else {
    const std::optional<BsdfSample> metal = sample_conductor(bsdf, bsdf.base_alpha, wo, u1, u2);
    if (!metal) return std::nullopt;
    wi = metal->wi;
  }
  const BsdfValue value = evaluate_with(bsdf, coat, coat_wo, wo, wi);
  if (!(value.pdf > 0)) return std::nullopt;
  return BsdfSample{wi, value.f_cos / value.pdf, value.pdf, false};
}

}  // namespace ld
