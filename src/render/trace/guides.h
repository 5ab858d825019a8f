// What the first hit of a path says about the surface: the features beside radiance.
#pragma once

#include "frame/schema.h"
#include "render/trace/prepared_scene.h"
#include "render/trace/virtual_image.h"

namespace ld {

/// In the units of frame/schema.cpp:
/// - normal: the shading normal in view space, turned to the viewer's side; 0 where the ray escaped;
/// - depth: of the hit along the view axis, kEscapedDepth where the ray escaped;
/// - albedo: colour of diffuse surfaces and of bases under a coat, what dielectrics transmit, of what shines
/// its
///   radiance scaled to a maximum of 1; 0 for conductors, mirrors, sky and probe;
/// - specular: reflectance at normal incidence of conductors, mirrors, dielectrics and clear coats over a
///   diffuse base, else 0; of a coated metal the metal's;
/// - roughness: square root of GGX's alpha (of a coat over a diffuse base, of the metal under a coat); 1 for
/// diffuse
///   surfaces and lights, 0 for mirror, smooth dielectric, sky and probe;
/// - motion: of the hit point through the lens centre from shutter open to close, 0 with an instant shutter;
/// where
///   the ray escaped, of the direction;
/// - coc: circle of confusion at the hit's depth, in the limit where the ray escaped;
/// - flow: from where the hit point is at shutter open to where it was at the previous frame's shutter open,
/// 0 where
///   there is no previous frame, kNoFlow after a cut;
/// - flow_depth: by how much its depth was larger then, 0 where there is no previous frame or the ray
/// escaped;
/// - id: 1 + the object's number, the lights behind the objects; 0 where the ray escaped.
struct Guides {
  Vec3 normal;
  float depth = kEscapedDepth;
  Vec3 albedo, specular;
  float roughness = 0;
  Vec2 motion;
  float coc = 0;
  Vec2 flow;
  float flow_depth = 0;
  int id = 0;
};

/// The material's colours and index at a surface point, as the path tracer sees them.
Bsdf bsdf_at(const Material& material, const Surface& surface, bool outside, float& roughness);

/// Fills Guides as a path goes. By default all of it is the first hit's. With `through_specular`, all but the
/// movement, which stays the first hit's, is that of the first surface that is neither mirror nor smooth
/// dielectric: the colours multiplied by what the path passed on its way there, depth, circle of confusion
/// and normal those of its virtual image (render/trace/virtual_image.h), the id its own.
class GuideRecorder {
 public:
  GuideRecorder(const PreparedScene& scene, float time, bool through_specular, Guides& guides);

  /// The ray left the scene. `first`: straight from the camera, here and below.
  void escaped(Vec3 direction, bool first);
  /// Something that shines `radiance` back along the ray of this direction.
  void light(const Surface& surface, Vec3 direction, Vec3 radiance, bool first);
  /// A surface with its shading normal (world, on the viewer's side) and what it is made of. Returns after
  /// noting whether the path goes on into what the surface mirrors or shows.
  void surface(const Surface& surface, Vec3 normal, const Bsdf& bsdf, float roughness, bool first);
  /// A perfectly specular surface multiplied the path by `weight` and turned it from `in` to `out`.
  void pass(Vec3 weight, Vec3 position, Vec3 in, Vec3 out, bool reflected) {
    filter_ *= weight;
    image_.pass(position, in, out, reflected);
  }

  bool complete() const { return complete_; }

 private:
  void place(const Surface& surface);
  void follow(const Surface& surface);

  const PreparedScene& scene_;
  std::optional<Camera> moved_;  // at the sample's time, where the camera moves
  const Camera& camera_;         // that or the scene's
  bool through_specular_, complete_ = false;
  Vec3 filter_ = grey(1);
  VirtualImage image_;
  Guides& guides_;
};

}  // namespace ld
