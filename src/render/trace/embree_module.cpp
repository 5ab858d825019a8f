#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cstring>
#include <limits>

#include "core/error.h"
#include "core/module.h"
#include "render/trace/ray_tracer.h"

namespace ld {
namespace {

#if RTC_VERSION_MAJOR >= 4
void intersect_one(RTCScene scene, RTCRayHit* query) {
  rtcIntersect1(scene, query);
}
void occluded_one(RTCScene scene, RTCRay* query) {
  rtcOccluded1(scene, query);
}
#else
void intersect_one(RTCScene scene, RTCRayHit* query) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, query);
}
void occluded_one(RTCScene scene, RTCRay* query) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcOccluded1(scene, &context, query);
}
#endif

void fill(RTCRay& query, const Ray& ray, float time, float nearest, float distance) {
  query.org_x = ray.origin.x;
  query.org_y = ray.origin.y;
  query.org_z = ray.origin.z;
  query.tnear = nearest;
  query.dir_x = ray.direction.x;
  query.dir_y = ray.direction.y;
  query.dir_z = ray.direction.z;
  query.time = time;
  query.tfar = distance;
  query.mask = ~0U;
  query.id = 0;
  query.flags = 0;
}

void check(RTCDevice device, const char* what) {
  if (const RTCError code = rtcGetDeviceError(device); code != RTC_ERROR_NONE)
    fail("Embree: {} failed with error {}; is there enough memory?", what, static_cast<int>(code));
}

void set_positions(RTCGeometry geometry, const Object& object, int step, int pieces) {
  auto* target = static_cast<float*>(
      rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, static_cast<unsigned>(step),
                              RTC_FORMAT_FLOAT3, 3 * sizeof(float), object.mesh.positions.size()));
  if (target == nullptr) return;
  const float time = static_cast<float>(step) / static_cast<float>(pieces);
  for (const Vec3& position : object.mesh.positions) {
    const Vec3 p = step == 0 ? position : object.motion.point(position, time);
    *target++ = p.x;
    *target++ = p.y;
    *target++ = p.z;
  }
}

class EmbreeTracer : public RayTracer {
 public:
  explicit EmbreeTracer(const std::vector<const Object*>& objects);
  bool intersect(const Ray& ray, float time, Hit& hit, float nearest) const override;
  bool occluded(const Ray& ray, float time, float distance) const override;

 private:
  struct Handles {
    RTCDevice device = nullptr;
    RTCScene scene = nullptr;
    ~Handles() {
      if (scene != nullptr) rtcReleaseScene(scene);
      if (device != nullptr) rtcReleaseDevice(device);
    }
  };
  Handles handles_;
};

EmbreeTracer::EmbreeTracer(const std::vector<const Object*>& objects) {
  // One thread builds the tree, so that it comes out the same whatever the machine is busy with.
  handles_.device = rtcNewDevice("threads=1");
  if (handles_.device == nullptr)
    fail("Embree: cannot make a device (error {})", static_cast<int>(rtcGetDeviceError(nullptr)));
  handles_.scene = rtcNewScene(handles_.device);
  // Robust: no ray slips through the edge between two triangles of a closed mesh.
  rtcSetSceneFlags(handles_.scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(handles_.scene, RTC_BUILD_QUALITY_HIGH);
  for (size_t i = 0; i < objects.size(); ++i) {
    const Object& object = *objects[i];
    RTCGeometry geometry = rtcNewGeometry(handles_.device, RTC_GEOMETRY_TYPE_TRIANGLE);
    const int pieces = object.motion.pieces(), steps = object.motion.still() ? 1 : pieces + 1;
    if (steps > 1) rtcSetGeometryTimeStepCount(geometry, static_cast<unsigned>(steps));
    for (int step = 0; step < steps; ++step) set_positions(geometry, object, step, pieces);
    void* triangles = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              3 * sizeof(uint32_t), object.mesh.triangles.size());
    check(handles_.device, "making a mesh");
    std::memcpy(triangles, object.mesh.triangles.data(), object.mesh.triangles.size() * 3 * sizeof(uint32_t));
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(handles_.scene, geometry, static_cast<unsigned>(i));
    rtcReleaseGeometry(geometry);
  }
  rtcCommitScene(handles_.scene);
  check(handles_.device, "building the tree");
}

bool EmbreeTracer::intersect(const Ray& ray, float time, Hit& hit, float nearest) const {
  if (log_ != nullptr) log_->push_back({ray, time, nearest, 0, false});
  RTCRayHit query;
  fill(query.ray, ray, time, nearest, std::numeric_limits<float>::infinity());
  query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  intersect_one(handles_.scene, &query);
  if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID) return false;
  hit.distance = query.ray.tfar;
  hit.object = query.hit.geomID;
  hit.triangle = query.hit.primID;
  hit.u = query.hit.u;
  hit.v = query.hit.v;
  hit.normal = {query.hit.Ng_x, query.hit.Ng_y, query.hit.Ng_z};
  return true;
}

bool EmbreeTracer::occluded(const Ray& ray, float time, float distance) const {
  if (log_ != nullptr) log_->push_back({ray, time, 0, distance, true});
  RTCRay query;
  fill(query, ray, time, 0, distance);
  occluded_one(handles_.scene, &query);
  return query.tfar < 0;
}

class EmbreeMaker : public RayTracerMaker {
 public:
  std::unique_ptr<RayTracer> build(const std::vector<const Object*>& objects) const override {
    return std::make_unique<EmbreeTracer>(objects);
  }
};

}  // namespace
}  // namespace ld

LD_MODULE(ld::RayTracerMaker, ld::EmbreeMaker)
