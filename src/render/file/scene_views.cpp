#include "render/file/scene_views.h"

#include <algorithm>
#include <cmath>

#include "render/trace/path_tracer.h"

namespace ld {
namespace {

// Index c of RandomStream(seed, scene, frame, attempt, c): beyond those of random scenes.
constexpr uint32_t kViewStream = 16, kViewExposureStream = 17;
constexpr uint32_t kAttempts = 32;

float degrees(double angle) {
  return static_cast<float>(angle) * kPi / 180;
}

FrameTimes times_at(const SceneFileConfig& config, double open, bool shutter) {
  const double length = shutter ? config.shutter * config.frame_time : 0;
  return {open, open + length, open - config.frame_time};
}

float radius_of(const Bounds& bounds) {
  return std::max(0.5F * length(bounds.high - bounds.low), 1e-6F);
}

/// How far ahead lies what a camera looks at: the middle of the scene, or for a camera in its middle some of
/// it.
float interest_distance(const Camera& camera, const Bounds& bounds) {
  return std::max(camera.depth(bounds.centre()), 0.25F * radius_of(bounds));
}

/// Whether the camera can move from one place to another around `pivot` without passing through anything.
bool way_is_free(const PreparedScene& look, Vec3 pivot, Vec3 from, Vec3 to) {
  constexpr int kSteps = 12;
  const float near = length(from - pivot), far = length(to - pivot);
  Vec3 before = from;
  for (int i = 1; i <= kSteps; ++i) {
    const float t = static_cast<float>(i) / kSteps;
    const Vec3 chord = mix(from, to, t) - pivot;
    // On the arc rather than its chord, which would pass through what stands in the middle.
    const Vec3 here = pivot + chord * ((near + t * (far - near)) / std::max(length(chord), 1e-6F * near));
    const Vec3 step = here - before;
    if (const float way = length(step); way > 0) {
      const auto hit = look.trace({before, step / way}, 0);
      if (hit && hit->distance < way) return false;
    }
    before = here;
  }
  return true;
}

/// Whether enough of the picture shows the file's objects, and little of it is right before the lens.
bool worth_seeing(const PreparedScene& look, const Camera& camera, float distance, bool ground) {
  constexpr int kGrid = 12;
  const auto objects =
      static_cast<int>(look.scene().objects.size()) - (ground ? 1 : 0);  // the ground comes last
  int seen = 0, near = 0;
  for (int j = 0; j < kGrid; ++j)
    for (int i = 0; i < kGrid; ++i) {
      const CameraSample where = {(static_cast<float>(i) + 0.5F) * static_cast<float>(camera.width) / kGrid,
                                  (static_cast<float>(j) + 0.5F) * static_cast<float>(camera.height) / kGrid,
                                  {},
                                  0};
      const auto surface = look.trace(camera.at(0).ray(where), 0);
      if (!surface) continue;
      if (surface->object < objects) ++seen;
      if (surface->distance < 0.05F * distance) ++near;
    }
  return seen >= kGrid * kGrid / 6 && near < kGrid * kGrid / 8;
}

/// The camera carried around what it looks at, `reach` of the whole way that is allowed.
Camera orbited(const Camera& base, float distance, float azimuth_limit, float elevation_limit, float reach,
               RandomStream& random) {
  const Vec3 pivot = base.position - base.axes.z * distance;
  const float azimuth = random.uniform(-1, 1) * azimuth_limit * reach;
  const float elevation = random.uniform(-1, 1) * elevation_limit * reach;
  const float nearer = 1 + random.uniform(-0.2F, 0.25F) * reach;
  const float right = random.uniform(-0.12F, 0.12F), up = random.uniform(-0.12F, 0.12F);
  const Vec3 arm = rotate(rotate(base.axes.z, base.axes.x, -elevation), {0, 1, 0}, azimuth);
  Camera camera = base;
  camera.position = pivot + arm * (distance * nearer);
  const Vec3 upwards = std::abs(arm.y) > 0.98F ? rotate(base.axes.y, {0, 1, 0}, azimuth) : Vec3{0, 1, 0};
  const Basis straight = look_at(camera.position, pivot, upwards);
  const Vec3 target = pivot + (straight.x * right + straight.y * up) * (distance * reach);
  camera.axes = look_at(camera.position, target, upwards);
  camera.fov = base.fov * (1 + random.uniform(-0.15F, 0.15F) * reach);
  return camera;
}

void add_defocus(Camera& camera, const PreparedScene& look, float distance, RandomStream& random) {
  const float x = random.uniform(0.35F, 0.65F), y = random.uniform(0.35F, 0.65F);
  const float share = 0.008F * std::pow(6.0F, random.uniform());  // how far the background blurs, in heights
  const CameraSample where = {
      x * static_cast<float>(camera.width), y * static_cast<float>(camera.height), {}, 0};
  const auto surface = look.trace(camera.ray(where), 0);
  camera.focus_distance = surface ? std::max(camera.depth(surface->position), 1e-3F * distance) : distance;
  camera.lens_radius =
      share * static_cast<float>(camera.height) * camera.focus_distance / camera.focal_pixels();
}

/// Moves while the shutter is open, as one in a hand does, its target kept.
void add_sweep(Camera& camera, float distance, RandomStream& random) {
  const float turn = random.uniform(0, 2 * kPi), share = 0.002F * std::pow(10.0F, random.uniform());
  const Vec3 step = (camera.axes.x * std::cos(turn) + camera.axes.y * std::sin(turn)) * (share * distance);
  const Vec3 target = camera.position - camera.axes.z * distance;
  camera.shutter = true;
  camera.close = CameraPose{camera.position + step, look_at(camera.position + step, target, camera.axes.y)};
}

}  // namespace

Camera framing_camera(const Bounds& bounds, int width, int height) {
  Camera camera;
  camera.width = width;
  camera.height = height;
  camera.fov = 0.7F;
  const float aspect = static_cast<float>(width) / static_cast<float>(height);
  const float half = std::atan(std::tan(0.5F * camera.fov) * std::min(1.0F, aspect));
  const Vec3 towards = normalize({0.47F, 0.36F, 0.81F}), centre = bounds.centre();
  camera.position = centre + towards * (radius_of(bounds) / std::sin(half));
  camera.axes = look_at(camera.position, centre, {0, 1, 0});
  return camera;
}

SceneView choose_view(const SceneFile& file, const SceneFileConfig& config, const PreparedScene& look,
                      uint64_t seed, uint32_t frame, int width, int height) {
  const auto cameras = static_cast<uint32_t>(file.camera_count());
  const Bounds bounds = file.bounds(config.time);
  const auto of_file = [&](uint32_t index, const FrameTimes& times) {
    Camera camera = file.camera(index, times);
    camera.width = width;
    camera.height = height;
    return camera;
  };
  SceneView view;
  if (config.file_cameras && frame < cameras) {
    view.times = times_at(config, config.time, file.duration() > 0 && config.motion_blur > 0);
    view.camera = of_file(frame, view.times);
    view.camera.previous.reset();
    view.distance = interest_distance(view.camera, bounds);
    view.name = "camera " + file.camera_name(frame);
    view.file_camera = static_cast<int>(frame);
    return view;
  }
  for (uint32_t attempt = 0;; ++attempt) {
    RandomStream random(seed, RandomPurpose::scene, frame, attempt, kViewStream);
    const double moment = file.duration() > 0 ? file.duration() * random.uniform() : config.time;
    const bool blurred = random.uniform() < config.motion_blur, thin_lens = random.uniform() < config.defocus;
    view.times = times_at(config, moment, blurred);
    const Camera base = cameras > 0 ? of_file(frame % cameras, times_at(config, moment, false))
                                    : framing_camera(bounds, width, height);
    view.distance = interest_distance(base, bounds);
    const float reach = 1 - static_cast<float>(attempt) / kAttempts;
    // Without a camera to go by, all the way around, a little below and far above the first guess.
    const float azimuth = cameras > 0 ? degrees(config.orbit) : kPi;
    const float elevation = cameras > 0 ? std::min(0.5F * azimuth, degrees(35)) : degrees(25);
    view.camera = orbited(base, view.distance, azimuth, elevation, reach, random);
    view.camera.close.reset();
    view.camera.previous.reset();
    view.camera.shutter = blurred;
    const Vec3 pivot = base.position - base.axes.z * view.distance;
    const bool good = way_is_free(look, pivot, base.position, view.camera.position) &&
                      worth_seeing(look, view.camera, view.distance, config.ground);
    if (!good && attempt < kAttempts) continue;
    view.name = thin_lens ? "view, defocus" : "view";
    if (thin_lens) add_defocus(view.camera, look, view.distance, random);
    if (blurred) {
      add_sweep(view.camera, view.distance, random);
      view.name += ", motion blur";
    }
    return view;
  }
}

void furnish(Scene& scene, const SceneFile& file, const SceneFileConfig& config,
             const std::optional<Probe>& probe) {
  if (probe) scene.probe = probe;
  const bool wants_sky = config.background == "sky" || (config.background == "auto" && !file.has_light());
  if (wants_sky && !scene.probe) {
    Sky sky;
    sky.zenith = {0.25F, 0.42F, 0.8F};
    sky.horizon = {0.75F, 0.85F, 1.0F};
    sky.ground = {0.26F, 0.28F, 0.3F};
    const float cos_radius = std::cos(0.06F);
    sky.patches.push_back({normalize({0.55F, 0.75F, 0.35F}), cos_radius,
                           Vec3{3.0F, 2.7F, 2.2F} / (kPi * (1 - cos_radius * cos_radius))});
    scene.sky = sky;
  }
  if (!config.ground) return;
  const Bounds bounds = file.bounds(config.time);
  const float radius = radius_of(bounds);
  Material grey_floor;
  grey_floor.colour = plain_texture(grey(0.45F));
  scene.materials.push_back(grey_floor);
  Object floor;
  floor.mesh = make_ground(60 * radius, 1, 0, 1, 0);
  const Vec3 centre = bounds.centre();
  place(floor.mesh, {1, 1, 1}, {}, {centre.x, bounds.low.y - 1e-3F * radius, centre.z});
  floor.material = static_cast<int>(scene.materials.size()) - 1;
  scene.objects.push_back(std::move(floor));
}

float automatic_exposure(const PreparedScene& scene, const Camera& camera, uint64_t seed) {
  constexpr int kGrid = 16, kPaths = 8;
  SampleNumbers numbers(RandomStream(seed, RandomPurpose::scene, 0, 0, kViewExposureStream));
  std::vector<float> luminances;
  for (int j = 0; j < kGrid; ++j)
    for (int i = 0; i < kGrid; ++i) {
      float sum = 0;
      for (int k = 0; k < kPaths; ++k) {
        const CameraSample where =
            draw_camera_sample(camera, i * camera.width / kGrid, j * camera.height / kGrid, numbers);
        sum += luminance(trace_path(scene, camera.at(where.time).ray(where), where.time, numbers, {}));
      }
      if (sum > 0) luminances.push_back(sum / kPaths);
    }
  if (luminances.empty()) return 1;
  const auto middle = luminances.begin() + static_cast<std::ptrdiff_t>(luminances.size() / 2);
  std::nth_element(luminances.begin(), middle, luminances.end());
  return 0.25F / *middle;
}

}  // namespace ld
