#include "render/shading/coat.h"

#include <cstdint>
#include <vector>

#include "core/random.h"
#include "render/shading/microfacet.h"

namespace ld {
namespace {

// Cosines are spaced as squares, because Fresnel rises at grazing angles; alphas as squares of the roughness.
constexpr int kCosines = 32, kAlphas = 13, kIndices = 8;
constexpr float kLowest = 1.01F, kHighest = 2.6F;

struct Row {
  float albedo[kCosines];
  float average;
};

float node_cosine(int i) {
  const float t = static_cast<float>(i) / (kCosines - 1);
  return t * t;
}

/// What a row interpolates to at `cos`.
float look_up(const float* albedo, float cos) {
  const float t = std::sqrt(std::clamp(cos, 0.0F, 1.0F)) * (kCosines - 1);
  const int i = std::min(static_cast<int>(t), kCosines - 2);
  const float low = node_cosine(i), high = node_cosine(i + 1);
  const float s = (std::clamp(cos, low, high) - low) / (high - low);
  return albedo[i] * (1 - s) + albedo[i + 1] * s;
}

/// Reflected share of the light from one direction: the mean of F G1 over visible normals.
float reflected(float cos, float alpha, float ior) {
  constexpr int kPoints = 1024;
  const float z = std::max(cos, 1e-3F);
  const Vec3 wo = {std::sqrt(1 - z * z), 0, z};
  float sum = 0;
  // The additive recurrence of Roberts ("The unreasonable effectiveness of quasirandom sequences", 2018), 32
  // bits of it.
  uint32_t u = 0x80000000U, v = 0x80000000U;
  for (int i = 0; i < kPoints; ++i, u += 0xC13FA9A9U, v += 0x91E10DA5U) {
    const Vec3 m = sample_ggx_visible_normal(wo, alpha, to_unit(u), to_unit(v));
    const Vec3 wi = m * (2 * dot(wo, m)) - wo;
    if (wi.z > 0) sum += fresnel_dielectric(dot(wo, m), ior) * ggx_masking(wi, alpha);
  }
  return sum / kPoints;
}

Row make_row(float alpha, float ior) {
  Row row;
  for (int i = 0; i < kCosines; ++i)
    row.albedo[i] = alpha == 0 ? fresnel_dielectric(std::max(node_cosine(i), 1e-4F), ior)
                               : reflected(node_cosine(i), alpha, ior);
  // Of the interpolated values, so that base and coat share out exactly what comes in.
  constexpr int kSteps = 512;
  double sum = 0;
  for (int i = 0; i < kSteps; ++i) {
    const float cos = (static_cast<float>(i) + 0.5F) / kSteps;
    sum += static_cast<double>(2 * cos * look_up(row.albedo, cos)) / kSteps;
  }
  row.average = static_cast<float>(sum);
  return row;
}

const std::vector<Row>& table() {
  static const std::vector<Row> rows = [] {
    std::vector<Row> made;
    for (int k = 0; k < kIndices; ++k)
      for (int a = 0; a < kAlphas; ++a) {
        const float roughness = static_cast<float>(a) / (kAlphas - 1);
        made.push_back(make_row(roughness * roughness,
                                kLowest + (kHighest - kLowest) * static_cast<float>(k) / (kIndices - 1)));
      }
    return made;
  }();
  return rows;
}

}  // namespace

CoatAlbedo::CoatAlbedo(float alpha, float ior) {
  const float a = std::sqrt(std::clamp(alpha, 0.0F, 1.0F)) * (kAlphas - 1);
  const float k = (std::clamp(ior, kLowest, kHighest) - kLowest) / (kHighest - kLowest) * (kIndices - 1);
  const int a0 = std::min(static_cast<int>(a), kAlphas - 2), k0 = std::min(static_cast<int>(k), kIndices - 2);
  const float s = a - static_cast<float>(a0), t = k - static_cast<float>(k0);
  const float weights[4] = {(1 - s) * (1 - t), s * (1 - t), (1 - s) * t, s * t};
  for (int i = 0; i < 4; ++i) {
    const Row& row = table()[(k0 + i / 2) * kAlphas + a0 + i % 2];
    rows_[i] = row.albedo;
    weights_[i] = weights[i];
    average_ += weights[i] * row.average;
  }
}

float CoatAlbedo::towards(float cos) const {
  float sum = 0;
  for (int i = 0; i < 4; ++i) sum += weights_[i] * look_up(rows_[i], cos);
  return sum;
}

}  // namespace ld
