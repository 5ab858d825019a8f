#include "render/random/draft_check.h"

#include <algorithm>
#include <map>
#include <vector>

#include "render/random/random_scene.h"
#include "render/trace/path_tracer.h"

namespace ld {
namespace {

constexpr int kDraftGrid = 24, kPaths = 4, kAll = kDraftGrid * kDraftGrid * kPaths;

/// What the camera rays meet first.
struct FirstHits {
  int near = 0, inside = 0, escaped = 0, specular = 0;
  std::map<int, int> objects;  // how often each was met
};

struct Draft {
  FirstHits hits;
  std::vector<float> luminances;  // sorted
  float share(float quantile) const {
    return luminances[static_cast<size_t>(quantile * static_cast<float>(luminances.size() - 1))];
  }
};

bool is_clear(const Material& material) {
  return material.kind == MaterialKind::smooth_dielectric ||
         material.kind == MaterialKind::rough_dielectric || material.kind == MaterialKind::mirror;
}

void count_hit(const PreparedScene& scene, const Ray& ray, float time, float depth_scale, FirstHits& hits) {
  const auto surface = scene.trace(ray, time);
  if (!surface) {
    ++hits.escaped;
    return;
  }
  const float depth = surface->distance * depth_scale;
  if (depth < 0.4F) ++hits.near;
  if (surface->object < 0) return;
  ++hits.objects[surface->object];
  if (is_clear(scene.material_of(*surface, -ray.direction))) {
    ++hits.specular;
    if (dot(surface->geometric_normal, ray.direction) > 0) ++hits.inside;
  }
}

Draft take_picture(const PreparedScene& scene, SampleNumbers numbers) {
  const Camera& camera = scene.scene().camera;
  Draft picture;
  for (int j = 0; j < kDraftGrid; ++j)
    for (int i = 0; i < kDraftGrid; ++i) {
      float sum = 0;
      for (int k = 0; k < kPaths; ++k) {
        const CameraSample where = draw_camera_sample(camera, i * camera.width / kDraftGrid,
                                                      j * camera.height / kDraftGrid, numbers);
        const Camera now = camera.at(where.time);
        const Ray ray = now.ray(where);
        count_hit(scene, ray, where.time, -dot(ray.direction, now.axes.z), picture.hits);
        sum += luminance(trace_path(scene, ray, where.time, numbers, {}));
      }
      picture.luminances.push_back(sum / kPaths);
    }
  std::sort(picture.luminances.begin(), picture.luminances.end());
  return picture;
}

DraftFault fault_of(const Draft& picture, float exposure) {
  const FirstHits& hits = picture.hits;
  if (hits.near > kAll / 8) return DraftFault::too_close;
  if (hits.inside > kAll / 50) return DraftFault::inside;
  if (hits.escaped > kAll * 11 / 20) return DraftFault::empty;
  if (picture.share(0.2F) == 0) return DraftFault::black;
  if (hits.specular > kAll * 2 / 5) return DraftFault::glassy;
  int most = 0, seen = 0;
  for (const auto& [object, count] : hits.objects) {
    most = std::max(most, count);
    seen += count > kAll / 400;
  }
  const float dark = picture.share(0.1F) * exposure, middle = picture.share(0.5F) * exposure,
              bright = picture.share(0.9F) * exposure;
  if (most > kAll * 7 / 10 || seen < 6 || bright - dark < 0.35F * middle) return DraftFault::monotonous;
  if (middle < 0.06F || picture.share(0.25F) * exposure < 0.008F) return DraftFault::harsh;
  return DraftFault::none;
}

}  // namespace

const char* fault_name(DraftFault fault) {
  switch (fault) {
    case DraftFault::none:
      return "none";
    case DraftFault::too_close:
      return "too close";
    case DraftFault::inside:
      return "inside glass";
    case DraftFault::empty:
      return "empty";
    case DraftFault::black:
      return "black";
    case DraftFault::glassy:
      return "glass and mirrors only";
    case DraftFault::monotonous:
      return "monotonous";
    case DraftFault::harsh:
      return "harsh light";
  }
  return "";
}

DraftLook look_at_draft(const PreparedScene& scene, float target, uint64_t seed, uint32_t frame,
                        uint32_t attempt) {
  const SampleNumbers numbers(RandomStream(seed, RandomPurpose::scene, frame, attempt, kPilotStream));
  const Draft picture = take_picture(scene, numbers);
  DraftLook look;
  const float middle = picture.share(0.5F), bright = picture.share(0.9F);
  if (middle > 0) look.exposure = target / middle;
  if (bright * look.exposure > 2.5F) look.exposure = 2.5F / bright;
  look.fault = fault_of(picture, look.exposure);
  return look;
}

}  // namespace ld
