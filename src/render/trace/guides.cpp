#include "render/trace/guides.h"

namespace ld {
namespace {

/// Whether both points lie before their cameras.
bool both_seen(const Camera& from, Vec3 from_point, const Camera& to, Vec3 to_point) {
  return from.depth(from_point) > 0 && to.depth(to_point) > 0;
}

/// From where one camera sees a point to where another sees another; 0 when either lies behind its camera.
Vec2 shift(const Camera& from, Vec3 from_point, const Camera& to, Vec3 to_point) {
  if (!both_seen(from, from_point, to, to_point)) return {};
  const Vec2 a = from.project(from_point), b = to.project(to_point);
  return {b.x - a.x, b.y - a.y};
}

/// The same of a direction, which is infinitely far.
Vec2 shift_at_infinity(const Camera& from, const Camera& to, Vec3 direction) {
  return shift(from, from.position + direction, to, to.position + direction);
}

}  // namespace

Bsdf bsdf_at(const Material& material, const Surface& surface, bool outside, float& roughness) {
  Bsdf bsdf;
  bsdf.kind = material.kind;
  bsdf.colour = material.colour.evaluate(surface.texture);
  roughness = material.roughness;
  if (material.roughness_map) roughness *= material.roughness_map->evaluate(surface.texture).x;
  bsdf.alpha = roughness * roughness;
  bsdf.base_alpha = std::max(material.base_roughness * material.base_roughness, kSmallestAlpha);
  bsdf.metal_eta = material.metal_eta;
  bsdf.metal_k = material.metal_k;
  const bool coated = material.kind == MaterialKind::plastic || material.kind == MaterialKind::coated_metal;
  if (!coated || bsdf.alpha > 0) bsdf.alpha = std::max(bsdf.alpha, kSmallestAlpha);
  bsdf.eta = outside || coated ? material.ior : 1 / material.ior;
  return bsdf;
}

GuideRecorder::GuideRecorder(const PreparedScene& scene, float time, bool through_specular, Guides& guides)
    : scene_(scene),
      moved_(scene.scene().camera.moves() ? std::make_optional(scene.scene().camera.at(time)) : std::nullopt),
      camera_(moved_ ? *moved_ : scene.scene().camera),
      through_specular_(through_specular),
      guides_(guides) {}

void GuideRecorder::place(const Surface& surface) {
  guides_.id = 1 + (surface.object >= 0 ? surface.object
                                        : static_cast<int>(scene_.scene().objects.size()) + surface.light);
  guides_.depth = camera_.depth(image_.position(surface.position));
  guides_.coc = camera_.circle_of_confusion(guides_.depth);
}

/// How the surface moves in the picture.
void GuideRecorder::follow(const Surface& surface) {
  const Camera& camera = scene_.scene().camera;
  const bool object = surface.object >= 0;
  const Object* moving = object ? &scene_.scene().objects[static_cast<size_t>(surface.object)] : nullptr;
  const Vec3 open = surface.at_open;
  if (camera.shutter && (camera.close || (moving != nullptr && !moving->motion.still())))
    guides_.motion =
        shift(camera.at(0), open, camera.at(1), moving != nullptr ? moving->motion.point(open, 1) : open);
  if (scene_.scene().cut) {
    guides_.flow = {kNoFlow, kNoFlow};
  } else if (camera.previous || (moving != nullptr && !moving->previous.still())) {
    const Camera now = camera.at(0), then = camera.at_previous();
    const Vec3 before = moving != nullptr ? moving->previous.point(open, 1) : open;
    guides_.flow = shift(now, open, then, before);
    if (both_seen(now, open, then, before)) guides_.flow_depth = then.depth(before) - now.depth(open);
  }
}

void GuideRecorder::escaped(Vec3 direction, bool first) {
  complete_ = true;
  guides_.coc = camera_.circle_of_confusion_at_infinity();
  if (!first) {
    // What the mirror or glass shows is the sky, which has no surface.
    const Guides nothing;
    guides_.normal = nothing.normal;
    guides_.depth = nothing.depth;
    guides_.albedo = nothing.albedo;
    guides_.specular = nothing.specular;
    guides_.roughness = nothing.roughness;
    guides_.id = nothing.id;
    return;
  }
  const Camera& camera = scene_.scene().camera;
  if (camera.shutter && camera.close)
    guides_.motion = shift_at_infinity(camera.at(0), camera.at(1), direction);
  if (scene_.scene().cut)
    guides_.flow = {kNoFlow, kNoFlow};
  else if (camera.previous)
    guides_.flow = shift_at_infinity(camera.at(0), camera.at_previous(), direction);
}

void GuideRecorder::light(const Surface& surface, Vec3 direction, Vec3 radiance, bool first) {
  complete_ = true;
  place(surface);
  if (first) follow(surface);
  const Vec3 normal = surface.geometric_normal;
  guides_.normal = camera_.to_view(image_.direction(dot(normal, direction) < 0 ? normal : -normal));
  guides_.albedo = is_black(radiance) ? Vec3{} : filter_ * radiance / max_component(radiance);
  guides_.specular = {};
  guides_.roughness = 1;
}

void GuideRecorder::surface(const Surface& surface, Vec3 normal, const Bsdf& bsdf, float roughness,
                            bool first) {
  place(surface);
  if (first) follow(surface);
  complete_ = !(through_specular_ && bsdf.is_delta());
  guides_.normal = camera_.to_view(image_.direction(normal));
  guides_.roughness = roughness;
  guides_.albedo = guides_.specular = {};
  const float r = (bsdf.eta - 1) / (bsdf.eta + 1);
  switch (bsdf.kind) {
    case MaterialKind::diffuse:
      guides_.albedo = bsdf.colour;
      guides_.roughness = 1;
      break;
    case MaterialKind::mirror:
      guides_.roughness = 0;
      [[fallthrough]];
    case MaterialKind::rough_conductor:
      guides_.specular = bsdf.conductor_fresnel(1);
      break;
    case MaterialKind::coated_metal:
      guides_.specular = bsdf.conductor_fresnel(1);
      guides_.roughness = std::sqrt(bsdf.base_alpha);
      break;
    case MaterialKind::smooth_dielectric:
      guides_.roughness = 0;
      [[fallthrough]];
    case MaterialKind::rough_dielectric:
    case MaterialKind::plastic:
      guides_.albedo = bsdf.colour;
      guides_.specular = grey(r * r);
      break;
    case MaterialKind::mixed:
      break;
  }
  guides_.albedo *= filter_;
  guides_.specular *= filter_;
}

}  // namespace ld
