// Sampling, energy and reciprocity of every scattering function.
#include "render/shading/bsdf.h"

#include <gtest/gtest.h>

#include <vector>

#include "core/random.h"
#include "render/shading/coat.h"
#include "render/shading/metals.h"
#include "render/shading/microfacet.h"

namespace ld {
namespace {

struct Case {
  const char* name;
  Bsdf bsdf;
};

Bsdf make_bsdf(MaterialKind kind, float alpha, float eta) {
  return {kind, kind == MaterialKind::diffuse ? grey(0.7F) : grey(1), alpha, eta};
}

Bsdf coated(MaterialKind kind, float coat_alpha, float ior, float base_alpha) {
  Bsdf bsdf = make_bsdf(kind, coat_alpha, ior);
  bsdf.base_alpha = base_alpha;
  return bsdf;
}

Bsdf metal(size_t which, float alpha) {
  Bsdf bsdf = make_bsdf(MaterialKind::rough_conductor, alpha, 1);
  bsdf.metal_eta = metals()[which].eta;
  bsdf.metal_k = metals()[which].k;
  return bsdf;
}

Bsdf regularised(MaterialKind kind, float alpha, float eta) {
  Bsdf bsdf = make_bsdf(kind, 1e-3F, eta);
  bsdf.regularise(alpha);
  return bsdf;
}

const std::vector<Case> kRoughCases = {
    {"diffuse", make_bsdf(MaterialKind::diffuse, 1, 1)},
    {"conductor, alpha 0.1", make_bsdf(MaterialKind::rough_conductor, 0.1F, 1)},
    {"conductor, alpha 0.5", make_bsdf(MaterialKind::rough_conductor, 0.5F, 1)},
    {"glass from outside, alpha 0.1", make_bsdf(MaterialKind::rough_dielectric, 0.1F, 1.5F)},
    {"glass from outside, alpha 0.4", make_bsdf(MaterialKind::rough_dielectric, 0.4F, 1.5F)},
    {"glass from inside, alpha 0.1", make_bsdf(MaterialKind::rough_dielectric, 0.1F, 1 / 1.5F)},
    {"glass from inside, alpha 0.4", make_bsdf(MaterialKind::rough_dielectric, 0.4F, 1 / 1.5F)},
    {"silver, alpha 0.3", metal(0, 0.3F)},
    {"plastic, coat alpha 0.1", coated(MaterialKind::plastic, 0.1F, 1.5F, 1)},
    {"plastic, coat alpha 0.6", coated(MaterialKind::plastic, 0.6F, 1.7F, 1)},
    {"coated metal, coat alpha 0.2", coated(MaterialKind::coated_metal, 0.2F, 1.5F, 0.4F)},
    {"mirror, regularised", regularised(MaterialKind::mirror, 0.1F, 1)},
    {"smooth glass, regularised", regularised(MaterialKind::smooth_dielectric, 0.1F, 1.5F)},
};
constexpr float kViewCosines[] = {0.95F, 0.6F, 0.25F};

Vec3 direction(double cosine, double azimuth) {
  const double sine = std::sqrt(std::max(0.0, 1 - cosine * cosine));
  return {static_cast<float>(sine * std::cos(azimuth)), static_cast<float>(sine * std::sin(azimuth)),
          static_cast<float>(cosine)};
}

// Bins of equal solid angle over the whole sphere.
constexpr int kLatitudes = 12, kLongitudes = 12;
int bin_of(Vec3 w) {
  const int i = std::clamp(static_cast<int>((w.z + 1) * 0.5F * kLatitudes), 0, kLatitudes - 1);
  const float turn = (std::atan2(w.y, w.x) + kPi) / (2 * kPi);
  return i * kLongitudes + std::clamp(static_cast<int>(turn * kLongitudes), 0, kLongitudes - 1);
}

/// The density integrated over each bin, by the midpoint rule on a fine grid.
std::vector<double> integrated_pdf(const Bsdf& bsdf, Vec3 wo) {
  constexpr int kFine = 48;
  std::vector<double> mass(size_t{kLatitudes} * kLongitudes, 0.0);
  const double cell = 4.0 * kPi / (kLatitudes * kLongitudes * kFine * kFine);
  for (int i = 0; i < kLatitudes * kFine; ++i)
    for (int j = 0; j < kLongitudes * kFine; ++j) {
      const Vec3 wi = direction(-1 + 2 * (i + 0.5) / (kLatitudes * kFine),
                                -kPi + 2 * kPi * (j + 0.5) / (kLongitudes * kFine));
      mass[static_cast<size_t>(bin_of(wi))] += bsdf.evaluate(wo, wi).pdf * cell;
    }
  return mass;
}

TEST(Bsdf, SamplesFollowTheirDensity) {
  constexpr int kDraws = 40000;
  for (const Case& c : kRoughCases)
    for (const float cosine : kViewCosines) {
      SCOPED_TRACE(c.name);
      SCOPED_TRACE(cosine);
      const Vec3 wo = direction(cosine, 0.7);
      const std::vector<double> mass = integrated_pdf(c.bsdf, wo);
      std::vector<int> counts(mass.size(), 0);
      RandomStream random(11, RandomPurpose::test, static_cast<uint32_t>(cosine * 100));
      int lost = 0;
      for (int k = 0; k < kDraws; ++k) {
        const float u0 = random.uniform(), u1 = random.uniform(), u2 = random.uniform();
        const auto drawn = c.bsdf.sample(wo, u0, u1, u2);
        if (!drawn) {
          ++lost;
          continue;
        }
        ++counts[static_cast<size_t>(bin_of(drawn->wi))];
      }
      double total = 0, chi2 = 0, expected_rest = 0;
      int bins = 0, found_rest = 0;
      for (size_t b = 0; b < mass.size(); ++b) {
        total += mass[b];
        const double expected = mass[b] * kDraws;
        if (expected < 10) {  // thin bins together make one
          expected_rest += expected;
          found_rest += counts[b];
          continue;
        }
        chi2 += (counts[b] - expected) * (counts[b] - expected) / expected;
        ++bins;
      }
      if (expected_rest > 10) {
        chi2 += (found_rest - expected_rest) * (found_rest - expected_rest) / expected_rest;
        ++bins;
      }
      // Density and lost draws together are everything.
      EXPECT_NEAR(total + static_cast<double>(lost) / kDraws, 1, 0.01);
      // Wilson and Hilferty: the cube root of chi^2 / k is normal. The quadrature adds up to 1 % to peaked
      // bins, which 5 deviations leave room for; a wrong Jacobian gives hundreds.
      const double k = std::max(1, bins);
      const double z = (std::cbrt(chi2 / k) - (1 - 2 / (9 * k))) / std::sqrt(2 / (9 * k));
      EXPECT_LT(z, 5) << "chi^2 " << chi2 << " over " << bins << " bins";
    }
}

TEST(Bsdf, WeightIsValueOverDensity) {
  for (const Case& c : kRoughCases) {
    SCOPED_TRACE(c.name);
    RandomStream random(12, RandomPurpose::test);
    int checked = 0;
    for (int k = 0; k < 2000; ++k) {
      const Vec3 wo = direction(0.1 + 0.9 * random.uniform(), 6 * random.uniform());
      const float u0 = random.uniform(), u1 = random.uniform(), u2 = random.uniform();
      const auto drawn = c.bsdf.sample(wo, u0, u1, u2);
      if (!drawn) continue;
      const BsdfValue value = c.bsdf.evaluate(wo, drawn->wi);
      EXPECT_NEAR(length(drawn->wi), 1, 1e-4);
      EXPECT_FALSE(drawn->delta);
      EXPECT_NEAR(drawn->pdf, value.pdf, 1e-4 * value.pdf);
      EXPECT_NEAR(drawn->weight.x * value.pdf, value.f_cos.x, 1e-4 * value.f_cos.x + 1e-7);
      ++checked;
    }
    EXPECT_GT(checked, 1000);
  }
}

TEST(Bsdf, IsReciprocal) {
  for (const Case& c : kRoughCases) {
    SCOPED_TRACE(c.name);
    RandomStream random(13, RandomPurpose::test);
    int checked = 0;
    for (int k = 0; k < 20000 && checked < 2000; ++k) {
      const Vec3 wo = direction(0.1 + 0.9 * random.uniform(), 6 * random.uniform());
      const Vec3 wi = direction(2 * random.uniform() - 1, 6 * random.uniform());
      const BsdfValue forth = c.bsdf.evaluate(wo, wi);
      if (std::abs(wi.z) < 0.1F || forth.f_cos.x < 1e-4F) continue;
      ++checked;
      // Seen from the other side the surface is upside down and its index inverted; radiance scales by eta^2
      // (Veach 1997, eq. 5.14).
      const bool through = wi.z < 0;
      Bsdf other = c.bsdf;
      if (through) other.eta = 1 / c.bsdf.eta;
      const float sign = through ? -1.0F : 1.0F;
      const BsdfValue back = other.evaluate({wi.x, wi.y, sign * wi.z}, {wo.x, wo.y, sign * wo.z});
      const float scale = through ? c.bsdf.eta * c.bsdf.eta : 1.0F;
      const float f = forth.f_cos.x / std::abs(wi.z) * scale, g = back.f_cos.x / std::abs(wo.z);
      EXPECT_NEAR(f, g, 5e-3F * std::max(f, g) + 1e-5F);
    }
    EXPECT_GE(checked, 200);
  }
}

TEST(Bsdf, NeverReturnsMoreThanItGot) {
  for (const Case& c : kRoughCases)
    for (const float cosine : kViewCosines) {
      const Vec3 wo = direction(cosine, 0);
      double energy = 0;
      constexpr int kGrid = 400;
      for (int i = 0; i < kGrid; ++i)
        for (int j = 0; j < kGrid; ++j) {
          const Vec3 wi = direction(-1 + 2 * (i + 0.5) / kGrid, 2 * kPi * (j + 0.5) / kGrid);
          // Undo the scaling of transmitted radiance: energy, not radiance, is conserved.
          energy += c.bsdf.evaluate(wo, wi).f_cos.x * (wi.z < 0 ? c.bsdf.eta * c.bsdf.eta : 1) * 4 * kPi /
                    (kGrid * kGrid);
        }
      EXPECT_LT(energy, 1.005) << c.name << ", cosine " << cosine;
      EXPECT_GT(energy, c.bsdf.kind == MaterialKind::diffuse ? 0.69 : 0.6) << c.name << ", cosine " << cosine;
    }
}

TEST(Bsdf, SmoothCoatSharesItsDrawsWithTheBase) {
  for (const MaterialKind kind : {MaterialKind::plastic, MaterialKind::coated_metal}) {
    const Bsdf bsdf = coated(kind, 0, 1.5F, 0.3F);
    EXPECT_FALSE(bsdf.is_delta());
    for (const float cosine : kViewCosines) {
      const Vec3 wo = direction(cosine, 0.4);
      RandomStream random(14, RandomPurpose::test);
      double mirrored = 0, based = 0;
      constexpr int kDraws = 20000;
      for (int k = 0; k < kDraws; ++k) {
        const float u0 = random.uniform(), u1 = random.uniform(), u2 = random.uniform();
        const auto drawn = bsdf.sample(wo, u0, u1, u2);
        if (!drawn) continue;
        (drawn->delta ? mirrored : based) += static_cast<double>(drawn->weight.x) / kDraws;
        if (drawn->delta) {
          EXPECT_FLOAT_EQ(drawn->wi.z, wo.z);
          EXPECT_FLOAT_EQ(drawn->wi.x, -wo.x);
        } else {
          EXPECT_NEAR(drawn->weight.x * drawn->pdf, bsdf.evaluate(wo, drawn->wi).f_cos.x, 1e-4F);
        }
      }
      const double fresnel = fresnel_dielectric(cosine, 1.5F);
      EXPECT_NEAR(mirrored, fresnel, 0.02 * fresnel + 0.004);
      // A white diffuse base returns all that passes the coat; a rough metal beneath it loses some.
      if (kind == MaterialKind::plastic) {
        EXPECT_NEAR(mirrored + based, 1, 0.02);
      }
      EXPECT_LT(mirrored + based, 1.02);
      EXPECT_GT(mirrored + based, 0.6);
    }
  }
}

TEST(Bsdf, CoatAlbedoAgreesWithFresnelAndWithIntegration) {
  for (const float ior : {1.3F, 1.5F, 2.0F}) {
    const CoatAlbedo smooth(0, ior);
    for (const float cosine : {1.0F, 0.7F, 0.3F, 0.08F})
      EXPECT_NEAR(smooth.towards(cosine), fresnel_dielectric(cosine, ior), 0.01F) << ior << " " << cosine;
    // A rough coat over a black base is all that evaluate() has then.
    Bsdf black = coated(MaterialKind::plastic, 0.4F, ior, 1);
    black.colour = {};
    const CoatAlbedo rough(0.4F, ior);
    constexpr int kGrid = 300;
    for (const float cosine : kViewCosines) {
      double sum = 0;
      for (int i = 0; i < kGrid; ++i)
        for (int j = 0; j < kGrid; ++j)
          sum +=
              black.evaluate(direction(cosine, 0), direction((i + 0.5) / kGrid, 2 * kPi * (j + 0.5) / kGrid))
                  .f_cos.x *
              2 * kPi / (kGrid * kGrid);
      EXPECT_NEAR(rough.towards(cosine), sum, 0.003) << ior << " " << cosine;
    }
  }
}

TEST(Bsdf, MetalsReflectAsTheirIndexSays) {
  for (const Metal& m : metals())
    for (int c = 0; c < 3; ++c) {
      const double n = m.eta[c], k = m.k[c];
      const double normal = ((n - 1) * (n - 1) + k * k) / ((n + 1) * (n + 1) + k * k);
      EXPECT_NEAR(fresnel_conductor(1, m.eta[c], m.k[c]), normal, 1e-5) << m.name;
      EXPECT_NEAR(fresnel_conductor(0, m.eta[c], m.k[c]), 1, 1e-5) << m.name;
      for (float cosine = 0.05F; cosine < 1; cosine += 0.05F) {
        EXPECT_LE(fresnel_conductor(cosine, m.eta[c], m.k[c]), 1) << m.name;
        EXPECT_GT(fresnel_conductor(cosine, m.eta[c], m.k[c]), 0.3F) << m.name;
      }
      // Without absorption it is the dielectric's formula.
      EXPECT_NEAR(fresnel_conductor(0.3F, 1.5F, 0), fresnel_dielectric(0.3F, 1.5F), 1e-5F);
    }
}

TEST(Bsdf, MirrorReflects) {
  const Bsdf mirror = {MaterialKind::mirror, {0.9F, 0.8F, 0.7F}, 0, 1};
  const Vec3 wo = direction(0.4, 1);
  const auto drawn = mirror.sample(wo, 0.3F, 0.3F, 0.3F);
  ASSERT_TRUE(drawn.has_value());
  EXPECT_TRUE(drawn->delta);
  EXPECT_FLOAT_EQ(drawn->wi.x, -wo.x);
  EXPECT_FLOAT_EQ(drawn->wi.y, -wo.y);
  EXPECT_FLOAT_EQ(drawn->wi.z, wo.z);
  EXPECT_FLOAT_EQ(drawn->weight.y, 0.8F);
  EXPECT_EQ(mirror.evaluate(wo, drawn->wi).pdf, 0);
}

TEST(Bsdf, GlassRefractsBySnellAndFresnel) {
  const Bsdf glass = {MaterialKind::smooth_dielectric, grey(1), 0, 1.5F};
  // At normal incidence 4 % return.
  EXPECT_NEAR(fresnel_dielectric(1, 1.5F), 0.04F, 1e-6F);
  // At Brewster's angle only the perpendicular half is left: ((n^2-1)/(n^2+1))^2 / 2.
  EXPECT_NEAR(fresnel_dielectric(std::cos(std::atan(1.5F)), 1.5F), 0.5F * std::pow(1.25F / 3.25F, 2.0F),
              1e-5F);
  EXPECT_EQ(fresnel_dielectric(0.5F, 1 / 1.5F), 1) << "total reflection beyond 41.8 degrees";
  const Vec3 wo = direction(0.5, 2);
  const float reflectance = fresnel_dielectric(0.5F, 1.5F);
  const auto refracted = glass.sample(wo, reflectance + 1e-3F, 0, 0);
  const auto reflected = glass.sample(wo, reflectance - 1e-3F, 0, 0);
  ASSERT_TRUE(refracted && reflected);
  EXPECT_GT(reflected->wi.z, 0);
  EXPECT_FLOAT_EQ(reflected->weight.x, 1);
  EXPECT_LT(refracted->wi.z, 0);
  EXPECT_NEAR(refracted->wi.x, -wo.x / 1.5F, 1e-6F) << "Snell: sin / n";
  EXPECT_NEAR(refracted->wi.y, -wo.y / 1.5F, 1e-6F);
  EXPECT_NEAR(refracted->weight.x, 1 / 2.25F, 1e-6F);
}

}  // namespace
}  // namespace ld
