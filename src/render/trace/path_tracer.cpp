#include "render/trace/path_tracer.h"

#include "render/geometry/sampling.h"

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

/// `least_alpha`: of the surface's lobes; 0: as the material has them.
Vertex make_vertex(const PreparedScene& scene, const Surface& surface, Vec3 to_viewer, float least_alpha,
                   float& roughness) {
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

  const Material& material = scene.material_of(surface, to_viewer);
  vertex.bsdf = bsdf_at(material, surface, outside, roughness);
  if (least_alpha > 0) vertex.bsdf.regularise(least_alpha);
  return vertex;
}

/// Light straight from a lamp or the sky to the vertex and on to the viewer, by sampling the light.
Vec3 direct_light(const PreparedScene& scene, const Vertex& vertex, float time, LightStrategy strategy,
                  SampleNumbers& numbers) {
  const float choice = numbers.one();
  const Vec2 u = numbers.two();
  const std::optional<LightSample> light = scene.sample_light(vertex.position, time, choice, u.x, u.y);
  if (!light) return {};
  const Vec3 wi = vertex.basis.to_local(light->direction);
  if (!vertex.consistent(light->direction, wi)) return {};
  const BsdfValue value = vertex.bsdf.evaluate(vertex.wo, wi);
  const Vec3 contribution = value.f_cos * light->radiance;
  if (is_black(contribution)) return {};
  // The ray starts lifted off the surface, so it must stop short of the lamp.
  if (!scene.visible(vertex.leave(light->direction), time, light->distance * 0.999F)) return {};
  const bool only_way = light->delta || strategy != LightStrategy::mis;
  const float weight = only_way ? 1 : power_heuristic(light->pdf, value.pdf);
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

/// Whether a direction of this density was scattered so broadly that what follows may be regularised: no more
/// narrowly than by a diffuse surface, or than a microfacet reflection of alpha does at its peak. A function
/// of the path's points alone, so that however the path goes on, its next surface is the same.
bool is_broad(float pdf, float alpha) {
  return pdf * kPi <= std::max(1.0F, 1 / (4 * alpha * alpha));
}

}  // namespace

Vec3 clamp_contribution(Vec3 contribution, float bound) {
  const float largest = max_component(contribution);
  if (bound == 0 || !(largest > bound) || std::isinf(largest)) return contribution;
  // Divided first: the quotient of the two bounds may be a denormal number, which has few digits.
  for (int c = 0; c < 3; ++c) contribution[c] = std::min(contribution[c], contribution[c] / largest * bound);
  return contribution;
}

Vec3 trace_path(const PreparedScene& scene, const Ray& first_ray, float time, SampleNumbers& numbers,
                const PathSettings& settings, Guides* guides, RadianceParts* parts) {
  std::optional<GuideRecorder> recorder;
  if (guides != nullptr) recorder.emplace(scene, time, settings.guides_through_specular, *guides);
  Vec3 radiance, throughput = grey(1);
  Ray ray = first_ray;
  bool only_way = true;  // next-event estimation could not have found what this ray finds
  float bsdf_pdf = 0;
  int scattered_times = 0;  // from the first surface on that is neither mirror nor smooth glass
  const float least_alpha = settings.regularisation > 0
                                ? std::max(settings.regularisation * settings.regularisation, kSmallestAlpha)
                                : 0;
  bool regularised = false;
  /// What a contribution counts that was scattered `more` times since.
  const auto bounded = [&](Vec3 contribution, int more) {
    return scattered_times + more < 2 ? contribution
                                      : clamp_contribution(contribution, settings.indirect_clamp);
  };
  const auto bring = [&](Vec3 contribution, int segments) {
    radiance += contribution;
    if (parts == nullptr) return;
    (segments == 1 ? parts->emission : segments == 2 ? parts->direct : parts->indirect) += contribution;
  };
  for (int bounce = 0;; ++bounce) {
    numbers.seek(kCameraPairs + kBouncePairs * static_cast<uint32_t>(bounce));
    const bool first = bounce == 0;
    GuideRecorder* const record = recorder && !recorder->complete() ? &*recorder : nullptr;
    const std::optional<Surface> surface = scene.trace(ray, time);
    float light_pdf = 0;
    if (!surface) {
      if (record != nullptr) record->escaped(ray.direction, first);
      const Vec3 sky = scene.environment(ray.direction, light_pdf);
      bring(bounded(throughput * sky * claim(only_way, bsdf_pdf, light_pdf, settings.strategy), 0),
            bounce + 1);
      return radiance;
    }
    const Vec3 emitted = scene.emitted(*surface, ray.direction, light_pdf);
    if (!is_black(emitted))
      bring(bounded(throughput * emitted * claim(only_way, bsdf_pdf, light_pdf, settings.strategy), 0),
            bounce + 1);
    const bool shines = surface->light >= 0 || !is_black(emitted);
    if (record != nullptr && shines) record->light(*surface, ray.direction, emitted, first);
    if (surface->light >= 0) return radiance;
    if (bounce > 0 && bounce == settings.max_bounces && record == nullptr) return radiance;

    float roughness = 1;
    const Vertex vertex =
        make_vertex(scene, *surface, -ray.direction, regularised ? least_alpha : 0, roughness);
    if (record != nullptr && !shines)
      record->surface(*surface, vertex.basis.z, vertex.bsdf, roughness, first);
    if (bounce == settings.max_bounces) return radiance;

    const bool last = ends_here(vertex, bounce, settings);
    const LightStrategy strategy = last ? LightStrategy::light_sampling : settings.strategy;
    if (!vertex.bsdf.is_delta() && scene.has_lights() && strategy != LightStrategy::bsdf_sampling)
      bring(bounded(throughput * direct_light(scene, vertex, time, strategy, numbers), 1), bounce + 2);
    if (last) return radiance;

    const float choice = numbers.one();
    const Vec2 u = numbers.two();
    const std::optional<BsdfSample> scattered = vertex.bsdf.sample(vertex.wo, choice, u.x, u.y);
    if (!scattered) return radiance;
    const Vec3 direction = normalize(vertex.basis.to_world(scattered->wi));
    if (!vertex.consistent(direction, scattered->wi)) return radiance;
    throughput *= scattered->weight;
    if (is_black(throughput)) return radiance;
    if (record != nullptr && vertex.bsdf.is_delta())
      record->pass(scattered->weight, vertex.position, ray.direction, direction, scattered->wi.z > 0);
    only_way = scattered->delta;
    bsdf_pdf = scattered->pdf;
    if (scattered_times > 0 || !vertex.bsdf.is_delta()) ++scattered_times;
    if (least_alpha > 0 && !scattered->delta && is_broad(bsdf_pdf, least_alpha)) regularised = true;
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

std::array<float, kAllChannels> trace_sample(const PreparedScene& scene, const CameraSample& where,
                                             SampleNumbers& numbers, const PathSettings& settings) {
  Guides g;
  RadianceParts parts;
  const auto& [emission, direct, indirect] = parts;
  const Camera& camera = scene.scene().camera;
  const Vec3 radiance = trace_path(scene, camera.ray_at(where), where.time, numbers, settings, &g, &parts);
  return {radiance.x,
          radiance.y,
          radiance.z,
          g.normal.x,
          g.normal.y,
          g.normal.z,
          g.depth,
          g.albedo.x,
          g.albedo.y,
          g.albedo.z,
          g.specular.x,
          g.specular.y,
          g.specular.z,
          g.roughness,
          g.motion.x,
          g.motion.y,
          g.coc,
          where.lens.x,
          where.lens.y,
          where.time,
          g.flow.x,
          g.flow.y,
          static_cast<float>(g.id),
          g.flow_depth,
          direct.x,
          direct.y,
          direct.z,
          indirect.x,
          indirect.y,
          indirect.z,
          emission.x,
          emission.y,
          emission.z};
}

}  // namespace ld
