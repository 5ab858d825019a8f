#include "render/path_tracer.h"

#include "render/sampling.h"

namespace ld {
namespace {

// Pairs of numbers (SampleNumbers::seek) that the camera takes and that each bounce may take: two for a
// light, two for the way on.
constexpr uint32_t kCameraPairs = 3, kBouncePairs = 4;

/// A surface point as a path scatters there: everything turned to the viewer's side.
struct Vertex {
  Vec3 position, geometric_normal;
  Basis basis;
  Vec3 wo;  // local
  Bsdf bsdf;

  /// Light must pass the real surface on the same side as the smoothed one; elsewhere it would leak.
  bool consistent(Vec3 world, Vec3 local) const { return dot(world, geometric_normal) * local.z > 0; }

  /// The start of a ray, lifted off the surface on the side it leaves to.
  Ray leave(Vec3 direction) const {
    const float size = std::max({1.0F, std::abs(position.x), std::abs(position.y), std::abs(position.z)});
    const float lift = std::copysign(1e-4F * size, dot(direction, geometric_normal));
    return {position + geometric_normal * lift, direction};
  }
};

Vertex make_vertex(const PreparedScene& scene, const Surface& surface, Vec3 to_viewer, float time) {
  Vertex vertex;
  vertex.position = surface.position;
  const bool outside = dot(surface.geometric_normal, to_viewer) > 0;
  vertex.geometric_normal = outside ? surface.geometric_normal : -surface.geometric_normal;
  Vec3 normal = outside ? surface.shading_normal : -surface.shading_normal;
  // At the silhouette of a smoothed mesh the interpolated normal can face away from who sees it: tilt it just
  // back.
  constexpr float kGrazing = 0.02F;
  const float cos_viewer = dot(normal, to_viewer);
  if (cos_viewer < kGrazing) normal = normalize(normal + to_viewer * (kGrazing - cos_viewer));
  vertex.basis = basis_around(normal);
  vertex.wo = vertex.basis.to_local(to_viewer);

  const Material& material = scene.material_of(surface);
  vertex.bsdf.kind = material.kind;
  vertex.bsdf.colour = scene.colour_at(surface, time);
  vertex.bsdf.alpha = material.roughness * material.roughness;
  vertex.bsdf.eta = outside ? material.ior : 1 / material.ior;
  return vertex;
}

/// Light straight from a lamp or the sky to the vertex and on to the viewer, by sampling the light.
Vec3 direct_light(const PreparedScene& scene, const Vertex& vertex, float time, LightStrategy strategy,
                  SampleNumbers& numbers) {
  const float choice = numbers.one();
  const Vec2 u = numbers.two();
  const std::optional<LightSample> light = scene.sample_light(vertex.position, choice, u.x, u.y);
  if (!light) return {};
  const Vec3 wi = vertex.basis.to_local(light->direction);
  if (!vertex.consistent(light->direction, wi)) return {};
  const BsdfValue value = vertex.bsdf.evaluate(vertex.wo, wi);
  const Vec3 contribution = value.f_cos * light->radiance;
  if (is_black(contribution)) return {};
  // The ray starts lifted off the surface, so it must stop short of the lamp.
  if (!scene.visible(vertex.leave(light->direction), time, light->distance * 0.999F)) return {};
  const float weight = strategy == LightStrategy::mis ? power_heuristic(light->pdf, value.pdf) : 1;
  return contribution * (weight / light->pdf);
}

/// Whether light sampling alone serves a vertex: at the last one a ray on would only look for lamps, which a
/// diffuse surface finds as well by sampling them. Saves one ray in eleven.
bool ends_here(const Vertex& vertex, int bounce, const PathSettings& settings) {
  return bounce > 0 && bounce + 1 == settings.max_bounces && vertex.bsdf.kind == MaterialKind::diffuse &&
         settings.strategy == LightStrategy::mis;
}

/// The share of light that a BSDF sample may claim when it runs into a light of this density.
float claim(bool only_way, float bsdf_pdf, float light_pdf, LightStrategy strategy) {
  if (only_way || strategy == LightStrategy::bsdf_sampling) return 1;
  return strategy == LightStrategy::mis ? power_heuristic(bsdf_pdf, light_pdf) : 0;
}

void describe_place(const PreparedScene& scene, const Surface& surface, float time, Guides& guides) {
  const Camera& camera = scene.scene().camera;
  guides.depth = camera.depth(surface.position);
  guides.coc = camera.circle_of_confusion(guides.depth);
  if (surface.object < 0 || !camera.shutter) return;
  const Vec3 motion = scene.scene().objects[static_cast<size_t>(surface.object)].motion;
  if (is_black(motion)) return;
  const Vec3 at_open = surface.position - motion * time, at_close = at_open + motion;
  if (camera.depth(at_open) <= 0 || camera.depth(at_close) <= 0)
    return;  // passes behind the camera: no image there
  const Vec2 from = camera.project(at_open), to = camera.project(at_close);
  guides.motion = {to.x - from.x, to.y - from.y};
}

void describe_light(const PreparedScene& scene, const Surface& surface, Vec3 direction, Vec3 radiance,
                    Guides& guides) {
  guides.normal = scene.scene().camera.to_view(
      dot(surface.geometric_normal, direction) < 0 ? surface.geometric_normal : -surface.geometric_normal);
  guides.albedo = is_black(radiance) ? Vec3{} : radiance / max_component(radiance);
  guides.roughness = 1;
}

void describe_material(const PreparedScene& scene, const Vertex& vertex, const Material& material,
                       Guides& guides) {
  guides.normal = scene.scene().camera.to_view(vertex.basis.z);
  guides.roughness = material.roughness;
  const Vec3 colour = vertex.bsdf.colour;
  switch (material.kind) {
    case MaterialKind::diffuse:
      guides.albedo = colour;
      break;
    case MaterialKind::rough_conductor:
    case MaterialKind::mirror:
      guides.specular = colour;
      break;
    case MaterialKind::smooth_dielectric:
    case MaterialKind::rough_dielectric: {
      const float r = (material.ior - 1) / (material.ior + 1);
      guides.albedo = colour;
      guides.specular = grey(r * r);
      break;
    }
  }
}

}  // namespace

Vec3 trace_path(const PreparedScene& scene, const Ray& first_ray, float time, SampleNumbers& numbers,
                const PathSettings& settings, Guides* guides) {
  Vec3 radiance, throughput = grey(1);
  Ray ray = first_ray;
  bool only_way = true;  // next-event estimation could not have found what this ray finds
  float bsdf_pdf = 0;
  for (int bounce = 0;; ++bounce) {
    numbers.seek(kCameraPairs + kBouncePairs * static_cast<uint32_t>(bounce));
    const std::optional<Surface> surface = scene.trace(ray, time);
    float light_pdf = 0;
    if (!surface) {
      if (bounce == 0 && guides != nullptr)
        guides->coc = scene.scene().camera.circle_of_confusion_at_infinity();
      const Vec3 sky = scene.sky_radiance(ray.direction, light_pdf);
      return radiance + throughput * sky * claim(only_way, bsdf_pdf, light_pdf, settings.strategy);
    }
    if (bounce == 0 && guides != nullptr) describe_place(scene, *surface, time, *guides);
    if (surface->light >= 0) {
      const Vec3 lamp = scene.light_radiance(*surface, ray.direction, light_pdf);
      if (bounce == 0 && guides != nullptr) describe_light(scene, *surface, ray.direction, lamp, *guides);
      return radiance + throughput * lamp * claim(only_way, bsdf_pdf, light_pdf, settings.strategy);
    }
    if (bounce > 0 && bounce == settings.max_bounces) return radiance;

    const Vertex vertex = make_vertex(scene, *surface, -ray.direction, time);
    if (bounce == 0 && guides != nullptr)
      describe_material(scene, vertex, scene.material_of(*surface), *guides);
    if (bounce == settings.max_bounces) return radiance;

    const bool last = ends_here(vertex, bounce, settings);
    const LightStrategy strategy = last ? LightStrategy::light_sampling : settings.strategy;
    if (!vertex.bsdf.is_delta() && scene.has_lights() && strategy != LightStrategy::bsdf_sampling)
      radiance += throughput * direct_light(scene, vertex, time, strategy, numbers);
    if (last) return radiance;

    const float choice = numbers.one();
    const Vec2 u = numbers.two();
    const std::optional<BsdfSample> scattered = vertex.bsdf.sample(vertex.wo, choice, u.x, u.y);
    if (!scattered) return radiance;
    const Vec3 direction = normalize(vertex.basis.to_world(scattered->wi));
    if (!vertex.consistent(direction, scattered->wi)) return radiance;
    throughput *= scattered->weight;
    if (is_black(throughput)) return radiance;
    only_way = scattered->delta;
    bsdf_pdf = scattered->pdf;
    ray = vertex.leave(direction);
  }
}

CameraSample draw_camera_sample(const Camera& camera, int x, int y, SampleNumbers& numbers) {
  CameraSample sample;
  const Vec2 place = numbers.two(), lens = numbers.two();
  const float time = numbers.one();
  sample.x = static_cast<float>(x) + place.x;
  sample.y = static_cast<float>(y) + place.y;
  if (camera.lens_radius > 0) sample.lens = sample_disk(lens.x, lens.y);
  if (camera.shutter) sample.time = time;
  return sample;
}

std::array<float, kSampleChannels> trace_sample(const PreparedScene& scene, const CameraSample& where,
                                                SampleNumbers& numbers, const PathSettings& settings) {
  Guides g;
  const Vec3 radiance = trace_path(scene, scene.scene().camera.ray(where), where.time, numbers, settings, &g);
  return {radiance.x,   radiance.y,  radiance.z, g.normal.x, g.normal.y,   g.normal.z,
          g.depth,      g.albedo.x,  g.albedo.y, g.albedo.z, g.specular.x, g.specular.y,
          g.specular.z, g.roughness, g.motion.x, g.motion.y, g.coc,        where.lens.x,
          where.lens.y, where.time,  0,          0};
}

}  // namespace ld
