#include "benchmark/render_speed.h"

#include <fmt/format.h>

#include <algorithm>

#include "benchmark/measure.h"
#include "core/threads.h"
#include "render/random/random_scene.h"
#include "render/trace/image_renderer.h"

namespace ld {
namespace {

Material diffuse(Vec3 colour) {
  Material material;
  material.colour = plain_texture(colour);
  return material;
}

Scene cornell_box() {
  Scene scene;
  scene.name = "cornell box";
  scene.materials = {diffuse(grey(0.73F)), diffuse({0.63F, 0.06F, 0.05F}), diffuse({0.14F, 0.45F, 0.09F})};
  const auto wall = [&](Vec3 corner, Vec3 u, Vec3 v, int material) {
    scene.objects.push_back({make_parallelogram(corner, u, v), material, {}});
  };
  wall({-1, -1, -1}, {0, 0, 2}, {2, 0, 0}, 0);
  wall({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, 0);
  wall({-1, -1, -1}, {2, 0, 0}, {0, 2, 0}, 0);
  wall({-1, -1, 1}, {0, 0, -2}, {0, 2, 0}, 1);
  wall({1, -1, -1}, {0, 0, 2}, {0, 2, 0}, 2);
  const auto box = [&](Vec3 size, float turn, Vec3 centre) {
    Mesh mesh = make_box();
    place(mesh, size, {{std::cos(turn), 0, -std::sin(turn)}, {0, 1, 0}, {std::sin(turn), 0, std::cos(turn)}},
          centre);
    scene.objects.push_back({mesh, 0, {}});
  };
  box({0.3F, 0.6F, 0.3F}, 0.3F, {-0.35F, -0.4F, -0.3F});
  box({0.3F, 0.3F, 0.3F}, -0.3F, {0.35F, -0.7F, 0.35F});
  scene.lights.push_back({{-0.25F, 0.99F, -0.25F}, {0.5F, 0, 0}, {0, 0, 0.5F}, {17, 12, 4}});
  scene.camera.position = {0, 0, 3.9F};
  scene.camera.axes = look_at(scene.camera.position, {0, 0, 0}, {0, 1, 0});
  scene.camera.fov = 0.68F;
  scene.camera.focus_distance = 3.9F;
  return scene;
}

/// Puts recorded questions again, split evenly over the threads.
void replay(const RayTracer& tracer, const std::vector<RecordedRay>& rays, int threads) {
  const auto piece = (rays.size() + static_cast<size_t>(threads) - 1) / static_cast<size_t>(threads);
  parallel_for(threads, threads, [&](int64_t t) {
    const size_t begin = std::min(static_cast<size_t>(t) * piece, rays.size());
    const size_t end = std::min(begin + piece, rays.size());
    Hit hit;
    for (size_t i = begin; i < end; ++i) {
      const RecordedRay& r = rays[i];
      if (r.occlusion)
        tracer.occluded(r.ray, r.time, r.distance);
      else
        tracer.intersect(r.ray, r.time, hit, r.nearest);
    }
  });
}

RenderSpeed measure(PreparedScene& scene, int spp, int repeats, int threads) {
  RenderSettings settings;
  settings.spp = spp;
  std::vector<RecordedRay> rays;
  scene.tracer().record(&rays);
  render_samples(scene, settings);
  scene.tracer().record(nullptr);

  RenderSpeed speed;
  const Camera& camera = scene.scene().camera;
  speed.scene = scene.scene().name;
  speed.paths = int64_t{camera.width} * camera.height * spp;
  speed.rays = static_cast<int64_t>(rays.size());
  std::vector<double> ours, single, embree;
  // In turns, so that all three see the same machine.
  for (int k = 0; k < repeats; ++k) {
    settings.threads = threads;
    ours.push_back(time_ms([&] { render_samples(scene, settings); }));
    settings.threads = 1;
    single.push_back(time_ms([&] { render_samples(scene, settings); }));
    embree.push_back(time_ms([&] { replay(scene.tracer(), rays, threads); }));
  }
  speed.seconds = median(ours) / 1000;
  speed.single_seconds = median(single) / 1000;
  speed.embree_seconds = median(embree) / 1000;
  return speed;
}

double millions(int64_t count, double seconds) {
  return static_cast<double>(count) / seconds / 1e6;
}

}  // namespace

std::vector<RenderSpeed> measure_rendering(int size, int spp, int repeats, int threads) {
  std::vector<RenderSpeed> speeds;
  Scene box = cornell_box();
  box.camera.width = box.camera.height = size;
  PreparedScene prepared(std::move(box));
  speeds.push_back(measure(prepared, spp, repeats, threads));
  for (uint32_t frame = 0; frame < 4; ++frame) {
    const auto scene = prepare_random_scene({}, 1, frame, size, size);
    speeds.push_back(measure(*scene, spp, repeats, threads));
  }
  return speeds;
}

std::string markdown(const std::vector<RenderSpeed>& speeds, int threads) {
  std::string text = fmt::format(
      "| scene | million paths/s | rays a path | million rays/s | Embree alone | share | {} threads over one "
      "|\n"
      "| :--- | ---: | ---: | ---: | ---: | ---: | ---: |\n",
      threads);
  for (const RenderSpeed& s : speeds)
    text +=
        fmt::format("| {} | {:.3f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} | {:.2f} |\n", s.scene,
                    millions(s.paths, s.seconds), static_cast<double>(s.rays) / static_cast<double>(s.paths),
                    millions(s.rays, s.seconds), millions(s.rays, s.embree_seconds),
                    s.embree_seconds / s.seconds, s.single_seconds / s.seconds);
  return text;
}

nlohmann::ordered_json to_json(const std::vector<RenderSpeed>& speeds) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const RenderSpeed& s : speeds)
    json.push_back({{"scene", s.scene},
                    {"paths", s.paths},
                    {"rays", s.rays},
                    {"seconds", s.seconds},
                    {"single_thread_seconds", s.single_seconds},
                    {"embree_seconds", s.embree_seconds}});
  return json;
}

}  // namespace ld
