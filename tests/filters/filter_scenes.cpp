#include "filter_scenes.h"

#include <cmath>
#include <limits>
#include <random>

namespace ld {

Surfaces flat_wall(int width, int height, float step) {
  Surfaces wall(width, height);
  wall.has_position = wall.has_flow = true;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      wall.of.at(x, y, kId) = 1;
      wall.of.at(x, y, kNormalZ) = 1;
      wall.of.at(x, y, kDepth) = wall.of.at(x, y, kPositionZ) = 10;
      wall.of.at(x, y, kPositionX) = step * float(x);
      wall.of.at(x, y, kPositionY) = step * float(y);
    }
  return wall;
}

Surfaces busy_scene(int width, int height, uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<float> share(0, 1);
  Surfaces scene(width, height);
  scene.unit = 1.3F;
  scene.has_position = scene.has_flow = true;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int id = (x / 9 + 3 * (y / 7)) % 4;
      const float tilt = 0.2F * float(id), jitter = 0.05F * (share(random) - 0.5F);
      const float n[3] = {tilt + jitter, 0.3F * tilt - jitter, 1.0F};
      const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
      scene.of.at(x, y, kId) = share(random) < 0.03F ? std::numeric_limits<float>::quiet_NaN() : float(id);
      for (int c = 0; c < 3; ++c) scene.of.at(x, y, kNormalX + c) = n[c] / length;
      const float depth = 8 + 2 * float(id) + tilt * 0.05F * float(x) - 0.02F * float(y) + 0.01F * jitter;
      scene.of.at(x, y, kDepth) = scene.of.at(x, y, kPositionZ) = depth;
      scene.of.at(x, y, kPositionX) = depth * (float(x) + share(random)) / float(width);
      scene.of.at(x, y, kPositionY) = depth * (float(y) + share(random)) / float(height);
      scene.flow.at(x, y, 0) = 3 * share(random) - 1.5F;
      scene.flow.at(x, y, 1) = 2 * share(random) - 1;
      scene.flow.at(x, y, 2) = 0.02F * (share(random) - 0.5F);
    }
  return scene;
}

RowPlanes noise(int width, int height, int planes, uint64_t seed, bool exponential) {
  std::mt19937_64 random(seed);
  std::normal_distribution<float> normal;
  std::exponential_distribution<float> decay;
  return filled(width, height, planes,
                [&](int, int, int) { return exponential ? decay(random) : normal(random); });
}

RowPlanes cut(const RowPlanes& planes, int x, int y, int width, int height) {
  return filled(width, height, planes.planes(),
                [&](int p, int px, int py) { return planes.at(x + px, y + py, p); });
}

Surfaces cut(const Surfaces& surfaces, int x, int y, int width, int height) {
  Surfaces part(width, height);
  part.unit = surfaces.unit;
  part.has_flow = surfaces.has_flow;
  part.has_position = surfaces.has_position;
  fill(part.of, [&](int p, int px, int py) { return surfaces.of.at(x + px, y + py, p); });
  fill(part.flow, [&](int p, int px, int py) { return surfaces.flow.at(x + px, y + py, p); });
  return part;
}

Spread spread(const RowPlanes& planes, int plane, int border) {
  double sum = 0, squares = 0, count = 0;
  for (int y = border; y < planes.height() - border; ++y)
    for (int x = border; x < planes.width() - border; ++x) {
      const double value = planes.at(x, y, plane);
      sum += value;
      squares += value * value;
      ++count;
    }
  const double mean = sum / count;
  return {mean, squares / count - mean * mean};
}

}  // namespace ld
