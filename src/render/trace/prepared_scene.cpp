#include "render/trace/prepared_scene.h"

#include <cstring>
#include <utility>

#include "core/error.h"
#include "core/random.h"

namespace ld {
namespace {

constexpr uint32_t kOpacitySalt = 0x51ED27U, kMixSalt = 0x2F0B4AU;

uint32_t bits_of(float x) {
  uint32_t bits = 0;
  std::memcpy(&bits, &x, sizeof bits);
  return bits;
}

Vec2 blend(const std::vector<Vec2>& uvs, const std::array<uint32_t, 3>& corners, float w, float u, float v) {
  const Vec2 a = uvs[corners[0]], b = uvs[corners[1]], c = uvs[corners[2]];
  return {a.x * w + b.x * u + c.x * v, a.y * w + b.y * u + c.y * v};
}

/// A number in [0, 1) that a ray and its hit decide, for choices that consume none of the sample's own
/// numbers (pbrt-v4 decides opacity and mixed materials so).
float hashed_choice(Vec3 direction, float distance, uint32_t salt) {
  // xxHash's 32-bit rounds over the bits.
  uint32_t h = salt;
  for (const float x : {direction.x, direction.y, direction.z, distance}) {
    h += bits_of(x) * 0xC2B2AE3DU;
    h = ((h << 17) | (h >> 15)) * 0x27D4EB2FU;
  }
  h = (h ^ (h >> 15)) * 0x85EBCA77U;
  h = (h ^ (h >> 13)) * 0xC2B2AE3DU;
  return to_unit(h ^ (h >> 16));
}

}  // namespace

PreparedScene::PreparedScene(Scene scene) : scene_(std::move(scene)) {
  check();
  std::vector<const Object*> objects;
  for (const Object& object : scene_.objects) {
    objects.push_back(&object);
    if (scene_.materials[static_cast<size_t>(object.material)].opacity) has_opacity_ = true;
  }
  light_objects_.reserve(scene_.lights.size());  // the tracer is given their addresses
  for (const AreaLight& light : scene_.lights) {
    light_objects_.push_back({make_parallelogram(light.corner, light.edge_u, light.edge_v), -1, {}});
    objects.push_back(&light_objects_.back());
  }
  if (objects.empty()) fail("scene '{}' has neither objects nor lights", scene_.name);
  lights_ = std::make_unique<LightSampler>(scene_);
  tracer_ = RayTracer::build(objects);
}

void PreparedScene::check() const {
  const int count = static_cast<int>(scene_.materials.size());
  const auto known = [&](int material) { return material >= 0 && material < count; };
  for (const Object& object : scene_.objects)
    if (!known(object.material))
      fail("scene '{}': an object has material {}, expected 0 to {}", scene_.name, object.material,
           count - 1);
  for (const Material& material : scene_.materials) {
    if (material.kind != MaterialKind::mixed) continue;
    for (const int part : {material.first, material.second})
      if (!known(part) || scene_.materials[static_cast<size_t>(part)].kind == MaterialKind::mixed)
        fail(
            "scene '{}': a mixed material names material {}, expected one of 0 to {} that is not mixed "
            "itself",
            scene_.name, part, count - 1);
    if (!material.mask) fail("scene '{}': a mixed material without a mask", scene_.name);
  }
}

void PreparedScene::describe(const Hit& hit, float time, Surface& surface) const {
  const size_t count = scene_.objects.size();
  surface.distance = hit.distance;
  surface.triangle = hit.triangle;
  surface.object = hit.object < count ? static_cast<int>(hit.object) : -1;
  surface.light = hit.object < count ? -1 : static_cast<int>(hit.object - count);
  const Object& object = surface.light < 0 ? scene_.objects[hit.object] : light_objects_[hit.object - count];
  const auto& corners = object.mesh.triangles[hit.triangle];
  const auto& [a, b, c] = corners;
  const float w = 1 - hit.u - hit.v;
  // From the corners, not along the ray: the error then does not grow with the distance.
  const std::vector<Vec3>& p = object.mesh.positions;
  surface.at_open = p[a] * w + p[b] * hit.u + p[c] * hit.v;
  surface.geometric_normal = normalize(hit.normal);
  const std::vector<Vec3>& n = object.mesh.normals;
  if (object.motion.still()) {
    surface.position = surface.at_open;
    surface.texture.normal = surface.geometric_normal;
    surface.shading_normal =
        n.empty() ? surface.geometric_normal : normalize(n[a] * w + n[b] * hit.u + n[c] * hit.v);
  } else {
    surface.position = object.motion.point(surface.at_open, time);
    surface.texture.normal = normalize(cross(p[b] - p[a], p[c] - p[a]));
    surface.shading_normal =
        n.empty() ? surface.geometric_normal
                  : object.motion.direction(normalize(n[a] * w + n[b] * hit.u + n[c] * hit.v), time);
  }
  surface.texture.position = surface.at_open;
  if (!object.texture.still()) {
    surface.texture.position = object.texture.point(surface.at_open, 1);
    surface.texture.normal = object.texture.direction(surface.texture.normal, 1);
  }
  surface.texture.has_uv = !object.mesh.uvs.empty();
  if (surface.texture.has_uv) surface.texture.uv = blend(object.mesh.uvs, corners, w, hit.u, hit.v);
}

bool PreparedScene::passes(const Hit& hit, const Ray& ray) const {
  if (hit.object >= scene_.objects.size()) return false;
  const Material& material = scene_.materials[static_cast<size_t>(scene_.objects[hit.object].material)];
  if (!material.opacity) return false;
  Surface surface;
  describe(hit, 0, surface);
  return hashed_choice(ray.direction, hit.distance, kOpacitySalt) >=
         material.opacity->evaluate(surface.texture).x;
}

std::optional<Surface> PreparedScene::trace(const Ray& ray, float time) const {
  Hit hit;
  float nearest = 0;
  do {
    if (!tracer_->intersect(ray, time, hit, nearest)) return std::nullopt;
    nearest = hit.distance * (1 + 1e-5F);
  } while (has_opacity_ && passes(hit, ray));
  Surface surface;
  describe(hit, time, surface);
  return surface;
}

bool PreparedScene::visible(const Ray& ray, float time, float distance) const {
  if (!has_opacity_) return !tracer_->occluded(ray, time, distance);
  Hit hit;
  for (float nearest = 0; tracer_->intersect(ray, time, hit, nearest) && hit.distance < distance;
       nearest = hit.distance * (1 + 1e-5F))
    if (!passes(hit, ray)) return false;
  return true;
}

Vec3 PreparedScene::emitted(const Surface& surface, Vec3 direction, float& pdf) const {
  pdf = 0;
  const float cos_light = -dot(direction, surface.geometric_normal);
  if (cos_light <= 0) return {};
  if (surface.light >= 0) {
    const auto i = static_cast<size_t>(surface.light);
    pdf = lights_->area_light_pdf(i, surface.distance, cos_light);
    return scene_.lights[i].radiance;
  }
  const auto object = static_cast<size_t>(surface.object);
  const Material& material = scene_.materials[static_cast<size_t>(scene_.objects[object].material)];
  if (!material.emission) return {};
  pdf = lights_->triangle_pdf(object, surface.triangle, surface.distance, cos_light);
  return material.emission->evaluate(surface.texture);
}

Vec3 PreparedScene::environment(Vec3 direction, float& pdf) const {
  pdf = 0;
  if (!scene_.sky && !scene_.probe) return {};
  pdf = lights_->environment_pdf(direction);
  return scene_.sky ? scene_.sky->radiance(direction) : scene_.probe->radiance(direction);
}

void PreparedScene::scale_lights(float factor) {
  // The choice between lights goes by shares of the power and stays as it is.
  for (AreaLight& light : scene_.lights) light.radiance *= factor;
  for (PointLight& light : scene_.point_lights) light.intensity *= factor;
  for (DirectionalLight& light : scene_.directional_lights) light.irradiance *= factor;
  for (Material& material : scene_.materials)
    if (material.emission) {
      material.emission->colour_a *= factor;
      material.emission->colour_b *= factor;
    }
  if (scene_.probe) scene_.probe->scale *= factor;
  if (!scene_.sky) return;
  for (Vec3* colour : {&scene_.sky->zenith, &scene_.sky->horizon, &scene_.sky->ground}) *colour *= factor;
  for (SkyPatch& patch : scene_.sky->patches) patch.radiance *= factor;
}

const Material& PreparedScene::material_of(const Surface& surface, Vec3 to_viewer) const {
  const Material& material =
      scene_.materials[static_cast<size_t>(scene_.objects[static_cast<size_t>(surface.object)].material)];
  if (material.kind != MaterialKind::mixed) return material;
  const float choice = hashed_choice(to_viewer, surface.distance, kMixSalt);
  const bool second = choice < material.mask->evaluate(surface.texture).x;
  return scene_.materials[static_cast<size_t>(second ? material.second : material.first)];
}

}  // namespace ld
