// How fast the path tracer is: against Embree alone on the same rays, and on one and several threads.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace ld {

struct RenderSpeed {
  std::string scene;
  int64_t paths = 0, rays = 0;  // traced by one run
  double seconds = 0;           // of the path tracer, on all threads
  double single_seconds = 0;    // on one thread
  double embree_seconds = 0;    // Embree alone, the same rays in the same order, on all threads
};

/// A Cornell box (lamp, two boxes, diffuse walls) and random scenes of both families, `size` pixels a side:
/// medians of `repeats` runs.
std::vector<RenderSpeed> measure_rendering(int size, int spp, int repeats, int threads);

std::string markdown(const std::vector<RenderSpeed>& speeds, int threads);
nlohmann::ordered_json to_json(const std::vector<RenderSpeed>& speeds);

}  // namespace ld
