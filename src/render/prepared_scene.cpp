#include "render/prepared_scene.h"

#include <utility>

#include "core/error.h"

namespace ld {
namespace {

float share(const std::vector<float>& cumulative, size_t i) {
  return cumulative[i] - (i == 0 ? 0 : cumulative[i - 1]);
}

}  // namespace

PreparedScene::PreparedScene(Scene scene) : scene_(std::move(scene)) {
  std::vector<const Object*> objects;
  for (const Object& object : scene_.objects) {
    if (object.material < 0 || object.material >= static_cast<int>(scene_.materials.size()))
      fail("scene '{}': an object has material {}, expected 0 to {}", scene_.name, object.material,
           static_cast<int>(scene_.materials.size()) - 1);
    objects.push_back(&object);
  }
  std::vector<float> powers;
  light_objects_.reserve(scene_.lights.size());  // the tracer is given their addresses
  for (const AreaLight& light : scene_.lights) {
    light_objects_.push_back({make_parallelogram(light.corner, light.edge_u, light.edge_v), -1, {}});
    objects.push_back(&light_objects_.back());
    const Vec3 n = cross(light.edge_u, light.edge_v);
    light_geometry_.push_back({normalize(n), length(n)});
    powers.push_back(kPi * length(n) * luminance(light.radiance));
  }
  if (objects.empty()) fail("scene '{}' has neither objects nor lights", scene_.name);
  if (scene_.sky) {
    sky_sampler_.emplace(*scene_.sky);
    powers.push_back(sky_sampler_->power());
  }
  float total = 0, sum = 0;
  for (const float power : powers) total += power;
  if (total > 0)
    for (const float power : powers) choice_.push_back((sum += power) / total);
  tracer_ = std::make_unique<RayTracer>(objects);
}

std::optional<Surface> PreparedScene::trace(const Ray& ray, float time) const {
  Hit hit;
  if (!tracer_->intersect(ray, time, hit)) return std::nullopt;
  Surface surface;
  surface.distance = hit.distance;
  const size_t count = scene_.objects.size();
  surface.object = hit.object < count ? static_cast<int>(hit.object) : -1;
  surface.light = hit.object < count ? -1 : static_cast<int>(hit.object - count);
  const Object& object = surface.light < 0 ? scene_.objects[hit.object] : light_objects_[hit.object - count];
  const auto& [a, b, c] = object.mesh.triangles[hit.triangle];
  const float w = 1 - hit.u - hit.v;
  // From the corners, not along the ray: the error then does not grow with the distance.
  const std::vector<Vec3>& p = object.mesh.positions;
  surface.position = p[a] * w + p[b] * hit.u + p[c] * hit.v + object.motion * time;
  surface.geometric_normal = normalize(hit.normal);
  const std::vector<Vec3>& n = object.mesh.normals;
  surface.shading_normal =
      n.empty() ? surface.geometric_normal : normalize(n[a] * w + n[b] * hit.u + n[c] * hit.v);
  return surface;
}

std::optional<LightSample> PreparedScene::sample_light(Vec3 from, float u0, float u1, float u2) const {
  size_t i = 0;
  while (i + 1 < choice_.size() && u0 >= choice_[i]) ++i;
  const float chosen = share(choice_, i);
  if (!(chosen > 0)) return std::nullopt;
  if (i == scene_.lights.size()) {
    const float u = std::clamp((u0 - (i == 0 ? 0 : choice_[i - 1])) / chosen, 0.0F, 0x1.fffffep-1F);
    const SkySample drawn = sky_sampler_->sample(u, u1, u2);
    return LightSample{drawn.direction, std::numeric_limits<float>::infinity(),
                       scene_.sky->radiance(drawn.direction), drawn.pdf * chosen};
  }
  const AreaLight& light = scene_.lights[i];
  const Vec3 towards = light.corner + light.edge_u * u1 + light.edge_v * u2 - from;
  const float distance2 = dot(towards, towards);
  if (distance2 == 0) return std::nullopt;
  const float distance = std::sqrt(distance2);
  const Vec3 direction = towards / distance;
  const float cos_light = -dot(direction, light_geometry_[i].normal);
  if (cos_light <= 0) return std::nullopt;
  return LightSample{direction, distance, light.radiance,
                     chosen * distance2 / (light_geometry_[i].area * cos_light)};
}

Vec3 PreparedScene::light_radiance(const Surface& surface, Vec3 direction, float& pdf) const {
  const auto i = static_cast<size_t>(surface.light);
  const float cos_light = -dot(direction, light_geometry_[i].normal);
  pdf = 0;
  if (cos_light <= 0) return {};
  if (has_lights())
    pdf = share(choice_, i) * surface.distance * surface.distance / (light_geometry_[i].area * cos_light);
  return scene_.lights[i].radiance;
}

Vec3 PreparedScene::sky_radiance(Vec3 direction, float& pdf) const {
  pdf = 0;
  if (!scene_.sky) return {};
  if (has_lights()) pdf = share(choice_, scene_.lights.size()) * sky_sampler_->pdf(direction);
  return scene_.sky->radiance(direction);
}

void PreparedScene::scale_lights(float factor) {
  // The choice between lights goes by shares of the power and stays as it is.
  for (AreaLight& light : scene_.lights) light.radiance *= factor;
  if (!scene_.sky) return;
  for (Vec3* colour : {&scene_.sky->zenith, &scene_.sky->horizon, &scene_.sky->ground}) *colour *= factor;
  for (SkyPatch& patch : scene_.sky->patches) patch.radiance *= factor;
}

Vec3 PreparedScene::colour_at(const Surface& surface, float time) const {
  return material_of(surface).colour.evaluate(
      surface.position - scene_.objects[static_cast<size_t>(surface.object)].motion * time);
}

const Material& PreparedScene::material_of(const Surface& surface) const {
  return scene_.materials[static_cast<size_t>(scene_.objects[static_cast<size_t>(surface.object)].material)];
}

}  // namespace ld
