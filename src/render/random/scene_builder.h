// What the parts of a random scene share while it is being put together.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "core/random.h"
#include "render/geometry/mesh_tools.h"
#include "render/random/scene_assets.h"
#include "render/random/shapes/model.h"
#include "render/trace/scene.h"

namespace ld {

/// A level place that things may stand on: the floor, a table top, a shelf.
struct Spot {
  Vec3 low, high;           // the same y: that of the surface
  float smallest, largest;  // radius of what stands there
};

/// Boxes that are taken, for things not to run into each other.
class Occupancy {
 public:
  void take(const Bounds& box) { taken_.push_back(box); }
  /// No taken box overlaps the box shrunk to `share` of its size.
  bool is_free(const Bounds& box, float share = 0.9F) const;
  /// Distance to the nearest box, 0 inside.
  float distance(Vec3 p) const;

 private:
  std::vector<Bounds> taken_;
};

/// One placed model: objects [first, last) of the scene.
struct Placed {
  size_t first, last;
  Bounds bounds;
  bool upright;
};

class SceneBuilder {
 public:
  SceneBuilder(const RandomStream& stream, std::shared_ptr<const SceneAssets> files, double asset_share)
      : random(stream), assets(std::move(files)), asset_share_(asset_share) {}

  int add(const Material& material);
  void add(Mesh mesh, int material);
  void add(Mesh mesh, const Material& material) { add(std::move(mesh), add(material)); }
  /// Every part gets a material of its stuff. The model counts as one of the scene's objects.
  void add(const Model& model, bool upright);
  /// The same, placed: its unit radius becomes `radius`, its lowest point comes to the height of `foot` above
  /// which its middle stands, turned by `turn` about +y.
  void stand(Model model, Vec3 foot, float radius, float turn);
  /// A model whose lengths are metres already (not fitted to unit radius); takes its box.
  void furnish(Model model, Vec3 foot, float turn);

  bool from_assets() { return random.uniform() < static_cast<float>(asset_share_); }
  /// How many models were placed.
  int count() const { return static_cast<int>(placed.size()); }

  Scene scene;
  RandomStream random;
  std::shared_ptr<const SceneAssets> assets;
  Occupancy occupancy;
  std::vector<Placed> placed;
  std::vector<Spot> spots;  // the first is the floor
  float ceiling = 3;        // nothing hovers above it
  std::function<float(float, float)> floor = [](float, float) { return 0.0F; };

 private:
  double asset_share_;
};

/// Fills the spots with random models until the scene has `count` of them, sizes shrinking as it gets
/// crowded; `floating` is the share that hovers instead of standing. Keeps `clear` around the camera free.
void add_random_models(SceneBuilder& builder, int count, double floating, float clear);

}  // namespace ld
