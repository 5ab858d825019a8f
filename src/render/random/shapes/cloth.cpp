// Sheets with folds. Not simulated: formulas that look like cloth from a little way off.
#include "render/geometry/mesh_tools.h"
#include "render/geometry/noise.h"
#include "render/random/shapes/shapes.h"

namespace ld {

Mesh make_curtain(RandomStream& random) {
  const float folds = random.uniform(4, 11), depth = random.uniform(0.04F, 0.11F),
              gather = random.uniform(0, 0.35F);
  const float width = random.uniform(0.5F, 1), wander = random.uniform(0.2F, 0.7F);
  const uint32_t seed = random.bits();
  return make_surface(144, 40, kPi, [&](int i, int j) {
    const float u = share(i, 144), v = share(j, 40), fall = 1 - v;  // from the hem at v = 0 up to the rail
    const float drift = wander * gradient_noise({4 * u, 1.5F * v, 0.5F}, seed);
    const float phase = 2 * kPi * folds * u + 2 * drift;
    const float amplitude =
        depth * (0.55F + 0.45F * fall) * (1 + 0.5F * gradient_noise({6 * u, 0.5F, 3.5F}, seed));
    // Folds are wider than sines: the crests are drawn together.
    const float wave = std::sin(phase + 0.35F * std::sin(2 * phase));
    const float waist = 1 - gather * std::sin(kPi * v) * std::sin(kPi * v);
    const float hem = 0.02F * std::sin(phase) * fall;
    return Vec3{width * (2 * u - 1) * waist, 2 * v - 1 + hem, amplitude * wave};
  });
}

Mesh make_draped_sheet(RandomStream& random) {
  const float rest = random.uniform(0.35F, 0.6F);  // radius of what it lies on
  const float squareness = random.uniform(2, 6), folds = std::floor(random.uniform(5, 12));
  const float flare = random.uniform(0.08F, 0.2F), ripple = random.uniform(0.1F, 0.22F);
  const uint32_t seed = random.bits();
  constexpr int kCells = 96;
  return make_surface(kCells, kCells, kPi, [&](int i, int j) {
    const float x = 2 * share(i, kCells) - 1, z = 1 - 2 * share(j, kCells);
    // The support's edge in this direction is a superellipse.
    const float radius = std::sqrt(x * x + z * z), angle = std::atan2(z, x);
    const float c = std::abs(std::cos(angle)), s = std::abs(std::sin(angle));
    const float edge = rest * std::pow(std::pow(c, squareness) + std::pow(s, squareness), -1 / squareness);
    const float bumps = 0.008F * gradient_noise({5 * x, 0.5F, 5 * z}, seed);
    if (radius <= edge) return Vec3{x, bumps, z};
    const float over = radius - edge;
    const float fold = std::sin(folds * angle + 1.5F * gradient_noise({2 * c, 2 * s, 0.5F}, seed));
    const float out = edge + over * (flare + ripple * (0.5F + 0.5F * fold) * std::min(1.0F, 3 * over));
    const float bend = 0.05F * (1 - std::exp(-over / 0.05F));  // the edge is not sharp
    return Vec3{out / radius * x, bumps - (over - 0.6F * bend), out / radius * z};
  });
}

Mesh make_flag(RandomStream& random) {
  const float waves = random.uniform(1, 2.5F), height = random.uniform(0.05F, 0.16F),
              sag = random.uniform(0, 0.4F);
  const float skew = random.uniform(-1.5F, 1.5F);
  const uint32_t seed = random.bits();
  return make_surface(72, 44, kPi, [&](int i, int j) {
    const float u = share(i, 72), v = share(j, 44);
    const float phase = 2 * kPi * waves * u + skew * v;
    const float z =
        height * std::sqrt(u) * (std::sin(phase) + 0.6F * gradient_noise({4 * u, 3 * v, 0.5F}, seed));
    return Vec3{2 * u - 1, 1.2F * v - 0.6F - sag * u * u, z};
  });
}

Mesh make_crumpled_sheet(RandomStream& random) {
  const float height = random.uniform(0.08F, 0.3F), scale = random.uniform(1, 3);
  const uint32_t seed = random.bits();
  constexpr int kCells = 84;
  return make_surface(kCells, kCells, 0.9F, [&](int i, int j) {
    const float x = 2 * share(i, kCells) - 1, z = 1 - 2 * share(j, kCells);
    float ridges = 0, weight = 1, frequency = scale;
    for (uint32_t octave = 0; octave < 4; ++octave) {
      ridges +=
          weight * (1 - 2 * std::abs(gradient_noise(Vec3{x, 0, z} * frequency + grey(0.5F), seed + octave)));
      weight *= 0.5F;
      frequency *= 1.9F;
    }
    return Vec3{x, height * ridges, z};
  });
}

Mesh make_ribbon(RandomStream& random) {
  const float turns = random.uniform(1.5F, 4), width = random.uniform(0.06F, 0.2F),
              twist = random.uniform(0, 4);
  const float open = random.uniform(0.3F, 0.9F);
  const int rows = 160;
  return make_surface(6, rows, kPi, [&](int i, int j) {
    const float t = share(j, rows), angle = 2 * kPi * turns * t, radius = open + (1 - open) * t;
    const Vec3 out = {std::cos(angle), 0, std::sin(angle)};
    const Vec3 across = Vec3{0, 1, 0} * std::cos(twist * t) + out * std::sin(twist * t);
    return out * radius + Vec3{0, 1.6F * t - 0.8F, 0} + across * (width * (2 * share(i, 6) - 1));
  });
}

}  // namespace ld
