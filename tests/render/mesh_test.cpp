#include "render/geometry/mesh.h"

#include <gtest/gtest.h>

#include <map>
#include <utility>

#include "core/error.h"
#include "render/geometry/noise.h"
#include "render/trace/prepared_scene.h"
#include "tests/render/mesh_volume.h"
#include "tests/render/test_scenes.h"
#include "tests/support/expect_error.h"

namespace ld {
namespace {

/// Volume enclosed by a mesh, positive when its triangles are counter-clockwise from outside (divergence
/// theorem).
/// Every edge belongs to two triangles that run along it in opposite directions.
bool is_closed(const Mesh& mesh) {
  std::map<std::pair<uint32_t, uint32_t>, int> edges;
  for (const auto& t : mesh.triangles)
    for (size_t i = 0; i < 3; ++i) ++edges[{t[i], t[(i + 1) % 3]}];
  for (const auto& [edge, count] : edges) {
    const auto other = edges.find({edge.second, edge.first});
    if (count != 1 || other == edges.end()) return false;
  }
  return true;
}

/// The least cosine between a position's normal and the triangles around it.
float worst_normal(const Mesh& mesh) {
  float worst = 1;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 n =
        normalize(cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]));
    for (const uint32_t i : {a, b, c}) worst = std::min(worst, dot(n, mesh.normals[i]));
  }
  return worst;
}

TEST(Mesh, ShapesAreClosedAndFaceOutwards) {
  EXPECT_TRUE(is_closed(make_sphere(3)));
  EXPECT_NEAR(volume(make_sphere(4)), 4.0 / 3 * kPi, 0.02);
  EXPECT_GT(worst_normal(make_sphere(3)), 0.99F);
  EXPECT_EQ(make_sphere(3).triangles.size(), 20U * 64);

  EXPECT_TRUE(is_closed(make_box()));
  EXPECT_NEAR(volume(make_box()), 8, 1e-6);

  const Mesh torus = make_torus(0.3F, 64, 32);
  EXPECT_TRUE(is_closed(torus));
  EXPECT_NEAR(volume(torus), 2 * kPi * kPi * 0.09, 0.03);
  EXPECT_GT(worst_normal(torus), 0.97F);

  const Mesh blob = make_blob(0.4F, 1.5F, 3, 5, 4);
  EXPECT_TRUE(is_closed(blob));
  EXPECT_GT(volume(blob), 1);
  EXPECT_GT(worst_normal(blob), 0.3F);
  float smallest = 2, largest = 0;
  for (const Vec3 p : blob.positions) {
    smallest = std::min(smallest, length(p));
    largest = std::max(largest, length(p));
  }
  EXPECT_GT(largest - smallest, 0.1F) << "the displacement must be seen";

  EXPECT_GT(worst_normal(make_ground(4, 40, 0.5F, 0.3F, 1)), 0.5F);
  for (const Vec3 n : make_ground(4, 40, 0.5F, 0.3F, 1).normals) EXPECT_GT(n.y, 0.3F);
}

TEST(Mesh, PlacingTurnsNormalsWithTheSurface) {
  Mesh mesh = make_sphere(4);
  const Basis tilt = look_at({}, {1, 2, 3}, {0, 1, 0}, 0.5F);
  place(mesh, {2, 0.5F, 1}, tilt, {3, 4, 5});
  EXPECT_NEAR(volume(mesh), 4.0 / 3 * kPi, 0.02) << "scales 2, 1/2 and 1; a mirrored mesh would be negative";
  EXPECT_GT(worst_normal(mesh), 0.95F);
  for (const Vec3 n : mesh.normals) EXPECT_NEAR(length(n), 1, 1e-5);
  turn_inside_out(mesh);
  EXPECT_LT(volume(mesh), 0);
  EXPECT_GT(worst_normal(mesh), 0.95F);
}

TEST(Noise, IsSmoothBoundedAndSeeded) {
  float largest = 0, jump = 0, difference = 0;
  for (int i = 0; i < 4000; ++i) {
    const float t = static_cast<float>(i) * 0.01F - 20;
    const Vec3 p = {t, 0.3F * t, 1.7F - t};
    const float n = gradient_noise(p, 1);
    largest = std::max(largest, std::abs(n));
    jump = std::max(jump, std::abs(gradient_noise(p + grey(0.005F), 1) - n));
    difference = std::max(difference, std::abs(gradient_noise(p, 2) - n));
  }
  EXPECT_LE(largest, 1.1F);
  EXPECT_GT(largest, 0.4F);
  EXPECT_LT(jump, 0.04F) << "continuous across the cells, negative ones too";
  EXPECT_GT(difference, 0.3F) << "seeds give other patterns";
  EXPECT_EQ(gradient_noise({3, -2, 5}, 1), 0) << "zero on the lattice";
}

TEST(PreparedScene, NamesWhatIsWrongWithAScene) {
  EXPECT_ERROR(PreparedScene(Scene{}), "neither objects nor lights");
  Scene scene;
  scene.objects.push_back({make_box(), 2, {}});
  EXPECT_ERROR(PreparedScene(scene), "material 2");
}

TEST(PreparedScene, SeesAndShadowsMovingObjects) {
  Scene scene;
  scene.objects.push_back({make_sphere(3), 0, Vec3{4, 0, 0}});
  scene.materials.push_back({});
  const PreparedScene prepared(scene);
  const Ray ray = {{0, 0, 5}, {0, 0, -1}}, later = {{4, 0, 5}, {0, 0, -1}};
  ASSERT_TRUE(prepared.trace(ray, 0).has_value());
  EXPECT_NEAR(prepared.trace(ray, 0)->distance, 4, 1e-2);
  EXPECT_FALSE(prepared.trace(ray, 1).has_value());
  ASSERT_TRUE(prepared.trace(later, 1).has_value());
  EXPECT_NEAR(prepared.trace(later, 1)->position.x, 4, 1e-3);
  EXPECT_FALSE(prepared.visible(ray, 0, 10));
  EXPECT_TRUE(prepared.visible(ray, 0, 3)) << "the ball begins behind that";
  EXPECT_TRUE(prepared.visible(ray, 1, 10));
}

}  // namespace
}  // namespace ld
