// What a scene consists of. Scene units are arbitrary; +y is up in the random scenes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/geometry/camera.h"
#include "render/geometry/mesh.h"
#include "render/geometry/motion.h"
#include "render/shading/bsdf.h"
#include "render/shading/environment.h"
#include "render/shading/probe.h"
#include "render/shading/texture.h"

namespace ld {

struct Material {
  MaterialKind kind = MaterialKind::diffuse;
  Texture colour;  // albedo; reflectance at normal incidence; what a dielectric's transmission is multiplied
                   // by; of the base under a coat
  float roughness =
      1;  // GGX alpha = roughness^2; 0 for mirror and smooth dielectric, 1 for diffuse; of a coat, 0 smooth
  std::optional<Texture> roughness_map;  // its first component multiplies `roughness`
  float base_roughness = 0.5F;           // of the metal under the coat of coated_metal
  float ior = 1.5F;                      // of dielectrics and coats, against air outside
  Vec3 metal_eta, metal_k;               // of conductors: exact Fresnel where k is not black (metals.h)
  // mixed: for each sample material `second` with the probability that the mask's first component says, else
  // `first` (as pbrt-v4's mix material); neither may be mixed itself.
  int first = -1, second = -1;
  std::optional<Texture> mask;
  std::optional<Texture> emission;  // radiance that leaves the outside of the surface
  std::optional<Texture> opacity;   // its first component: the probability that a ray does not pass through
};

struct Object {
  Mesh mesh;  // at shutter open
  int material = 0;
  Motion motion;         // while the shutter is open
  Motion previous = {};  // at time 1 it takes a point at shutter open to where it was at the previous frame's
  // At time 1 it takes a point at shutter open to where its material looks textures up: where a mesh is made
  // anew for each frame of a sequence, they stick to it.
  Motion texture = {};
};

/// A parallelogram that shines to the side of cross(edge_u, edge_v) and is black otherwise.
struct AreaLight {
  Vec3 corner, edge_u, edge_v;
  Vec3 radiance;
};

/// Shines in all directions, or, with cones, around `direction`: fully within the inner one, falling smoothly
/// to 0 at the outer one.
struct PointLight {
  Vec3 position;
  Vec3 intensity;  // radiance times area, per steradian
  Vec3 direction = {0, -1, 0};
  float cos_inner = -1, cos_outer = -1;

  Vec3 intensity_towards(Vec3 direction_from_light) const;
};

/// Parallel light.
struct DirectionalLight {
  Vec3 direction;   // unit, towards the light
  Vec3 irradiance;  // on a surface that faces it
};

struct Scene {
  std::string name;  // for people: "indoor, defocus"
  std::vector<Object> objects;
  std::vector<Material> materials;
  std::vector<AreaLight> lights;
  std::vector<PointLight> point_lights;
  std::vector<DirectionalLight> directional_lights;
  std::optional<Sky> sky;
  std::optional<Probe> probe;  // or a sky, not both
  Camera camera;
  bool cut = false;  // in a sequence: the frame before showed something else
};

}  // namespace ld
