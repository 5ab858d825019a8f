#pragma once

#include "render/geometry/mesh.h"

namespace ld {

/// Inside a closed mesh; negative where its triangles face inwards.
inline double volume(const Mesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    sum += dot(mesh.positions[a], cross(mesh.positions[b], mesh.positions[c])) / 6.0;
  return sum;
}

}  // namespace ld
