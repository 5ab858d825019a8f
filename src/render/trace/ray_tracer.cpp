#include "render/trace/ray_tracer.h"

#include "core/module.h"

namespace ld {

std::unique_ptr<RayTracer> RayTracer::build(const std::vector<const Object*>& objects) {
  static const auto* const maker = static_cast<const RayTracerMaker*>(
      load_module("ld_embree", "finds what rays hit",
                  "install the program again, or build all of it (cmake --build --preset release)"));
  return maker->build(objects);
}

}  // namespace ld
