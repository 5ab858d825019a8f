// What a scene consists of. Scene units are arbitrary; +y is up in the random scenes.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "render/bsdf.h"
#include "render/camera.h"
#include "render/environment.h"
#include "render/mesh.h"
#include "render/texture.h"

namespace ld {

struct Material {
  MaterialKind kind = MaterialKind::diffuse;
  Texture
      colour;  // albedo; reflectance at normal incidence; what a dielectric's transmission is multiplied by
  float roughness = 1;  // GGX alpha = roughness^2; 0 for mirror and smooth dielectric, 1 for diffuse
  float ior = 1.5F;     // of dielectrics, against air outside
};

struct Object {
  Mesh mesh;  // at shutter open
  int material = 0;
  Vec3 motion;  // translation from shutter open to shutter close, scene units
};

/// A parallelogram that shines to the side of cross(edge_u, edge_v) and is black otherwise.
struct AreaLight {
  Vec3 corner, edge_u, edge_v;
  Vec3 radiance;
};

struct Scene {
  std::string name;  // for people: "indoor, defocus"
  std::vector<Object> objects;
  std::vector<Material> materials;
  std::vector<AreaLight> lights;
  std::optional<Sky> sky;
  Camera camera;
};

}  // namespace ld
