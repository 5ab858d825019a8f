// What bsdf.cpp shares with the coated materials.
#pragma once

#include "render/shading/bsdf.h"

namespace ld {

/// wi.z > 0 needed for a value: metal with GGX of `alpha`, without any coat.
BsdfValue evaluate_conductor(const Bsdf& bsdf, float alpha, Vec3 wo, Vec3 wi);
std::optional<BsdfSample> sample_conductor(const Bsdf& bsdf, float alpha, Vec3 wo, float u1, float u2);

/// plastic and coated_metal.
BsdfValue evaluate_coated(const Bsdf& bsdf, Vec3 wo, Vec3 wi);
std::optional<BsdfSample> sample_coated(const Bsdf& bsdf, Vec3 wo, float u0, float u1, float u2);

}  // namespace ld
