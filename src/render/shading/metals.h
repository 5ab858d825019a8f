// Metals as they are: complex indices of refraction.
#pragma once

#include <vector>

#include "render/geometry/vec3.h"

namespace ld {

struct Metal {
  const char* name;
  Vec3 eta, k;  // real and imaginary part, at about 650, 550 and 450 nm for R, G and B
};

/// Silver, aluminium, gold, copper, chromium, iron, nickel, titanium, platinum, tungsten; from the tables of
/// Johnson and Christy (1972, 1974), Rakic et al. (1998) and Palik (1985), rounded.
const std::vector<Metal>& metals();

}  // namespace ld
