#include "render/recipe/sequence.h"

namespace ld {

Motion part_of(const Motion& frame, float from, float frames) {
  Motion part = frame;
  part.translation = frame.translation * frames;
  part.angle = frame.angle * frames;
  part.pivot = frame.pivot + frame.translation * from;
  return part;
}

void carry(Mesh& mesh, const Motion& motion) {
  if (motion.still()) return;
  for (Vec3& p : mesh.positions) p = motion.point(p, 1);
  for (Vec3& n : mesh.normals) n = motion.direction(n, 1);
}

SequencePlan plan_sequence(Scene scene, float distance, int64_t length, float speed, RandomStream& random) {
  for (Object& object : scene.objects) object.motion = part_of(object.motion, 0, speed);
  Scene whole = scene;
  for (Object& object : whole.objects) object.motion = part_of(object.motion, 0, static_cast<float>(length));
  const Camera start = scene.camera.at(0);
  CameraPath path = plan_camera_path(PreparedScene(std::move(whole)), start, distance, length, speed, random);
  return {std::move(scene), std::move(path)};
}

Camera fly(const Camera& camera, const CameraPath& path, int64_t position, float shutter) {
  const auto frame = static_cast<float>(position);
  Camera flying = camera;
  const CameraPose open = path.at(frame);
  flying.position = open.position;
  flying.axes = open.axes;
  flying.shutter = shutter > 0;
  flying.close.reset();
  if (flying.shutter) flying.close = path.at(frame + shutter);
  flying.previous = path.at(frame - 1);
  return flying;
}

Scene sequence_frame(const SequencePlan& plan, int64_t position, float shutter) {
  const auto frame = static_cast<float>(position);
  const float gone = plan.progress(frame);
  Scene scene = plan.scene;
  for (Object& object : scene.objects) {
    const Motion way = object.motion;
    carry(object.mesh, part_of(way, 0, gone));
    object.motion = part_of(way, gone, plan.progress(frame, shutter));
    object.previous = part_of(way, gone, plan.progress(frame, -1));
    object.texture = part_of(way, gone, -gone);
  }
  scene.camera = fly(scene.camera, plan.path, position, shutter);
  return scene;
}

}  // namespace ld
