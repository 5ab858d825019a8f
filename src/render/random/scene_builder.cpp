#include "render/random/scene_builder.h"

#include <utility>

#include "render/random/model_materials.h"
#include "render/random/random_materials.h"

namespace ld {
namespace {

Bounds shrunk(const Bounds& box, float share) {
  const Vec3 centre = box.centre(), half = (box.high - box.low) * (0.5F * share);
  return {centre - half, centre + half};
}

bool overlap(const Bounds& a, const Bounds& b) {
  for (int i = 0; i < 3; ++i)
    if (a.low[i] >= b.high[i] || b.low[i] >= a.high[i]) return false;
  return true;
}

float distance_to(const Bounds& box, Vec3 p) {
  Vec3 gap;
  for (int i = 0; i < 3; ++i) gap[i] = std::max(0.0F, std::max(box.low[i] - p[i], p[i] - box.high[i]));
  return length(gap);
}

Model random_model(SceneBuilder& builder, bool& upright) {
  RandomStream& random = builder.random;
  if (builder.assets->has_meshes() && builder.from_assets()) {
    upright = chance(random, 0.7);
    Model model = builder.assets->model(random);
    return model;
  }
  const std::vector<ModelKind>& kinds = model_kinds();
  float total = 0;
  for (const ModelKind& kind : kinds) total += kind.likelihood;
  float left = random.uniform(0, total);
  size_t i = 0;
  while (i + 1 < kinds.size() && left >= kinds[i].likelihood) left -= kinds[i++].likelihood;
  upright = kinds[i].upright;
  return kinds[i].make(random);
}

}  // namespace

bool Occupancy::is_free(const Bounds& box, float share) const {
  const Bounds own = shrunk(box, share);
  return std::none_of(taken_.begin(), taken_.end(), [&](const Bounds& other) { return overlap(own, other); });
}

float Occupancy::distance(Vec3 p) const {
  float nearest = 1e9F;
  for (const Bounds& box : taken_) nearest = std::min(nearest, distance_to(box, p));
  return nearest;
}

int SceneBuilder::add(const Material& material) {
  scene.materials.push_back(material);
  return static_cast<int>(scene.materials.size()) - 1;
}

void SceneBuilder::add(Mesh mesh, int material) {
  scene.objects.push_back({std::move(mesh), material, {}, {}});
}

void SceneBuilder::add(const Model& model, bool upright) {
  Placed entry = {scene.objects.size(), 0, bounds_of(model), upright};
  for (const Part& part : model) {
    const int material = add_material_of(*this, part);
    add(part.mesh, material);
  }
  entry.last = scene.objects.size();
  placed.push_back(entry);
}

void SceneBuilder::stand(Model model, Vec3 foot, float radius, float turn) {
  place(model, grey(radius), turned_about({0, 1, 0}, turn), {});
  const Bounds bounds = bounds_of(model);
  place(model, grey(1), {}, {foot.x, foot.y - bounds.low.y, foot.z});
  occupancy.take(bounds_of(model));
  add(model, true);
}

void SceneBuilder::furnish(Model model, Vec3 foot, float turn) {
  place(model, grey(1), turned_about({0, 1, 0}, turn), foot);
  occupancy.take(bounds_of(model));
  add(model, true);
}

void add_random_models(SceneBuilder& builder, int count, double floating, float clear) {
  RandomStream& random = builder.random;
  const Vec3 camera = builder.scene.camera.position;
  float area = 0;
  for (size_t s = 1; s < builder.spots.size(); ++s) {
    const Vec3 size = builder.spots[s].high - builder.spots[s].low;
    area += size.x * size.z;
  }
  // Small places get more than their share of the area, or all would stand on the floor.
  const double on_spots = area > 0 ? 0.35 : 0;
  constexpr int kTries = 24;
  for (int i = builder.count(); i < count; ++i) {
    bool upright = false;
    Model model = random_model(builder, upright);
    const bool floats = chance(random, upright ? 0.4 * floating : floating);
    const bool on_spot = !floats && chance(random, on_spots);
    const size_t s = on_spot ? 1 + random.below(static_cast<uint32_t>(builder.spots.size() - 1)) : 0;
    const Spot spot = builder.spots[s];
    const Basis turn =
        upright && !floats ? turned_about({0, 1, 0}, random.uniform(0, 2 * kPi)) : random_rotation(random);
    for (int t = 0; t < kTries; ++t) {
      // The more tries, the smaller: a crowded place still takes small things.
      const float radius =
          log_uniform(random, spot.smallest, spot.largest) * (1 - 0.6F * static_cast<float>(t) / kTries);
      const float u = random.uniform(), v = random.uniform(), w = random.uniform();
      const Vec3 room = spot.high - spot.low;
      Vec3 at = {spot.low.x + u * room.x, spot.low.y, spot.low.z + v * room.z};
      const bool roomy = s != 0 || (room.x > 2 * radius && room.z > 2 * radius);
      if (s == 0) {
        at.x = spot.low.x + radius + u * (room.x - 2 * radius);
        at.z = spot.low.z + radius + v * (room.z - 2 * radius);
        at.y = builder.floor(at.x, at.z);
      }
      Model trial = model;
      place(trial, grey(radius), turn, {});
      const Bounds around = bounds_of(trial);
      const float lift =
          floats ? w * std::max(0.0F, builder.ceiling - at.y - (around.high.y - around.low.y)) : 0.0F;
      const Vec3 move = {at.x, at.y + lift - around.low.y, at.z};
      const Bounds box = {around.low + move, around.high + move};
      const bool under_roof = box.high.y < builder.ceiling || s == 0;
      if (!roomy || !under_roof || distance_to(box, camera) < clear || !builder.occupancy.is_free(box))
        continue;
      place(trial, grey(1), {}, move);
      builder.occupancy.take(box);
      builder.add(trial, upright);
      break;
    }
  }
}

}  // namespace ld
