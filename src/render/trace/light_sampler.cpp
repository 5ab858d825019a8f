#include "render/trace/light_sampler.h"

#include <limits>

#include "core/error.h"

namespace ld {
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Density over solid angle of a point drawn uniformly on an area.
float solid_angle_pdf(float chosen, float area, float distance, float cos_light) {
  return cos_light > 0 ? chosen * distance * distance / (area * cos_light) : 0;
}

/// Middle of the triangle, as textures see it.
TexturePoint middle_of(const Mesh& mesh, const std::array<uint32_t, 3>& corners) {
  TexturePoint point;
  const Vec3 a = mesh.positions[corners[0]], b = mesh.positions[corners[1]], c = mesh.positions[corners[2]];
  point.position = (a + b + c) / 3;
  const Vec3 n = cross(b - a, c - a);
  if (!is_black(n)) point.normal = normalize(n);
  point.has_uv = !mesh.uvs.empty();
  if (point.has_uv)
    for (const uint32_t i : corners) {
      point.uv.x += mesh.uvs[i].x / 3;
      point.uv.y += mesh.uvs[i].y / 3;
    }
  return point;
}

/// Mean squared distance of the local lights from where the camera focuses; 1 without such lights.
float reach_of(const Scene& scene) {
  const Vec3 focus = scene.camera.position - scene.camera.axes.z * scene.camera.focus_distance;
  float sum = 0, count = 0;
  const auto add = [&](Vec3 place) {
    sum += dot(place - focus, place - focus);
    ++count;
  };
  for (const AreaLight& light : scene.lights) add(light.corner + 0.5F * (light.edge_u + light.edge_v));
  for (const PointLight& light : scene.point_lights) add(light.position);
  for (const Object& object : scene.objects)
    if (scene.materials[static_cast<size_t>(object.material)].emission && !object.mesh.positions.empty())
      add(object.mesh.positions[0]);
  return count == 0 ? 1 : std::max(sum / count, 1e-4F);
}

/// The powers of one kind of light.
struct Kind {
  size_t begin, end;
};

}  // namespace

Vec3 PointLight::intensity_towards(Vec3 from_light) const {
  if (cos_outer <= -1) return intensity;
  const float cos = dot(from_light, direction);
  if (cos <= cos_outer) return {};
  if (cos >= cos_inner) return intensity;
  const float t = (cos - cos_outer) / (cos_inner - cos_outer);
  return intensity * (t * t * (3 - 2 * t));
}

LightSampler::LightSampler(const Scene& scene) {
  if (scene.sky && scene.probe)
    fail("scene '{}' has both a sky and a probe; expected one of them", scene.name);
  if (scene.sky) sky_.emplace(*scene.sky);
  if (scene.probe) probe_.emplace(*scene.probe);
  for (const AreaLight& light : scene.lights) {
    const Vec3 n = cross(light.edge_u, light.edge_v);
    areas_.push_back({normalize(n), length(n)});
  }
  for (size_t o = 0; o < scene.objects.size(); ++o) {
    const Mesh& mesh = scene.objects[o].mesh;
    const bool emits = scene.materials[static_cast<size_t>(scene.objects[o].material)].emission.has_value();
    first_triangle_.push_back(emits ? static_cast<int64_t>(triangles_.size()) : -1);
    if (!emits) continue;
    for (size_t t = 0; t < mesh.triangles.size(); ++t) {
      const auto& [a, b, c] = mesh.triangles[t];
      const Vec3 n = cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
      triangles_.push_back({o, t, 0.5F * length(n)});
    }
  }
  add_powers(scene);
}

void LightSampler::add_powers(const Scene& scene) {
  const float disk = kPi * reach_of(scene);
  std::vector<float> powers;
  std::vector<Kind> kinds;
  const auto end_kind = [&](size_t begin) {
    if (powers.size() > begin) kinds.push_back({begin, powers.size()});
    return powers.size();
  };
  for (size_t i = 0; i < areas_.size(); ++i)
    powers.push_back(kPi * areas_[i].area * luminance(scene.lights[i].radiance));
  first_point_ = end_kind(0);
  for (const PointLight& light : scene.point_lights)
    powers.push_back(2 * kPi * (1 - std::max(light.cos_outer, -1.0F)) * luminance(light.intensity));
  first_parallel_ = end_kind(first_point_);
  for (const DirectionalLight& light : scene.directional_lights)
    powers.push_back(disk * luminance(light.irradiance));
  environment_ = end_kind(first_parallel_);
  if (sky_ || probe_) powers.push_back(disk * 0.5F * (sky_ ? sky_->power() : probe_->power()));
  first_emitter_ = end_kind(environment_);
  for (const EmissiveTriangle& t : triangles_) {
    const Object& object = scene.objects[t.object];
    const Texture& emission = *scene.materials[static_cast<size_t>(object.material)].emission;
    // Never 0: a picture may be dark at the middle of the triangle and bright elsewhere.
    powers.push_back(t.area * (kPi * luminance(emission.evaluate(
                                         middle_of(object.mesh, object.mesh.triangles[t.triangle]))) +
                               0.01F * luminance(emission.colour_a)));
  }
  end_kind(first_emitter_);

  const auto sum_of = [&](const Kind& kind) {
    double sum = 0;
    for (size_t i = kind.begin; i < kind.end; ++i) sum += static_cast<double>(powers[i]);
    return sum;
  };
  double total = 0;
  int shining = 0;
  for (const Kind& kind : kinds) {
    total += sum_of(kind);
    if (sum_of(kind) > 0) ++shining;
  }
  if (!(total > 0)) return;
  double sum = 0;
  for (const Kind& kind : kinds) {
    const double own = sum_of(kind);
    const double factor = own > 0 ? 0.5 / total + 0.5 / (shining * own) : 0;
    for (size_t i = kind.begin; i < kind.end; ++i)
      choice_.push_back(static_cast<float>(sum += factor * static_cast<double>(powers[i])));
  }
}

std::optional<LightSample> LightSampler::sample(const Scene& scene, Vec3 from, float time, float u0, float u1,
                                                float u2) const {
  const size_t i = choose_bin(choice_.data(), choice_.size(), u0);
  const float chosen = bin_share(choice_.data(), i);
  if (!(chosen > 0)) return std::nullopt;
  if (i < first_point_) return sample_area_light(scene.lights[i], i, from, u1, u2);
  if (i < first_parallel_) {
    const PointLight& light = scene.point_lights[i - first_point_];
    const Vec3 towards = light.position - from;
    const float distance = length(towards);
    if (distance == 0) return std::nullopt;
    const Vec3 direction = towards / distance;
    return LightSample{direction, distance, light.intensity_towards(-direction) / (distance * distance),
                       chosen, true};
  }
  if (i < environment_) {
    const DirectionalLight& light = scene.directional_lights[i - first_parallel_];
    return LightSample{light.direction, kInfinity, light.irradiance, chosen, true};
  }
  if (i < first_emitter_) {
    const SkySample drawn = sky_ ? sky_->sample(u0, u1, u2) : probe_->sample(u1, u2);
    const Vec3 radiance =
        sky_ ? scene.sky->radiance(drawn.direction) : scene.probe->radiance(drawn.direction);
    if (!(drawn.pdf > 0)) return std::nullopt;
    return LightSample{drawn.direction, kInfinity, radiance, drawn.pdf * chosen, false};
  }
  return sample_triangle(scene, triangles_[i - first_emitter_], chosen, from, time, u1, u2);
}

std::optional<LightSample> LightSampler::sample_area_light(const AreaLight& light, size_t i, Vec3 from,
                                                           float u1, float u2) const {
  const Vec3 towards = light.corner + light.edge_u * u1 + light.edge_v * u2 - from;
  const float distance = length(towards);
  if (distance == 0) return std::nullopt;
  const Vec3 direction = towards / distance;
  const float pdf = area_light_pdf(i, distance, -dot(direction, areas_[i].normal));
  if (!(pdf > 0)) return std::nullopt;
  return LightSample{direction, distance, light.radiance, pdf, false};
}

std::optional<LightSample> LightSampler::sample_triangle(const Scene& scene, const EmissiveTriangle& which,
                                                         float chosen, Vec3 from, float time, float u1,
                                                         float u2) const {
  const Object& object = scene.objects[which.object];
  const auto& corners = object.mesh.triangles[which.triangle];
  // Uniform on the triangle: the square folded along its diagonal.
  if (u1 + u2 > 1) {
    u1 = 1 - u1;
    u2 = 1 - u2;
  }
  const float w = 1 - u1 - u2;
  Vec3 p[3];
  for (size_t k = 0; k < 3; ++k) p[k] = object.mesh.positions[corners[k]];
  TexturePoint point = middle_of(object.mesh, corners);
  point.position = p[0] * w + p[1] * u1 + p[2] * u2;
  if (point.has_uv) {
    const std::vector<Vec2>& uv = object.mesh.uvs;
    point.uv = {uv[corners[0]].x * w + uv[corners[1]].x * u1 + uv[corners[2]].x * u2,
                uv[corners[0]].y * w + uv[corners[1]].y * u1 + uv[corners[2]].y * u2};
  }
  const Vec3 normal = object.motion.direction(point.normal, time);
  const Vec3 towards = object.motion.point(point.position, time) - from;
  const float distance = length(towards);
  if (distance == 0) return std::nullopt;
  const Vec3 direction = towards / distance;
  const float pdf = solid_angle_pdf(chosen, which.area, distance, -dot(direction, normal));
  if (!(pdf > 0) || !std::isfinite(pdf)) return std::nullopt;
  point.position = object.texture.still() ? point.position : object.texture.point(point.position, 1);
  point.normal = object.texture.direction(point.normal, 1);
  const Vec3 radiance = scene.materials[static_cast<size_t>(object.material)].emission->evaluate(point);
  return LightSample{direction, distance, radiance, pdf, false};
}

float LightSampler::area_light_pdf(size_t light, float distance, float cos_light) const {
  if (empty()) return 0;
  return solid_angle_pdf(bin_share(choice_.data(), light), areas_[light].area, distance, cos_light);
}

float LightSampler::triangle_pdf(size_t object, size_t triangle, float distance, float cos_light) const {
  if (empty() || first_triangle_[object] < 0) return 0;
  const size_t i = static_cast<size_t>(first_triangle_[object]) + triangle;
  return solid_angle_pdf(bin_share(choice_.data(), first_emitter_ + i), triangles_[i].area, distance,
                         cos_light);
}

float LightSampler::environment_pdf(Vec3 direction) const {
  if (empty() || (!sky_ && !probe_)) return 0;
  return bin_share(choice_.data(), environment_) * (sky_ ? sky_->pdf(direction) : probe_->pdf(direction));
}

}  // namespace ld
