// Every kind of model of the random scenes, for random parameters; and the building blocks against closed
// forms.
#include "render/random/shapes/shapes.h"

#include <gtest/gtest.h>

#include <map>
#include <set>
#include <tuple>

#include "render/geometry/mesh_tools.h"
#include "render/random/shapes/model.h"
#include "tests/render/mesh_volume.h"

namespace ld {
namespace {

using Place = std::tuple<float, float, float>;

/// How many edges between places (not positions: seams double those) are not run along as often one way as
/// the other.
size_t open_edges(const Mesh& mesh) {
  std::map<Place, int> places;
  const auto place_of = [&](uint32_t i) {
    const Vec3 p = mesh.positions[i] + grey(0);
    return places.try_emplace({p.x, p.y, p.z}, static_cast<int>(places.size())).first->second;
  };
  std::map<std::pair<int, int>, int> edges;
  for (const auto& t : mesh.triangles) {
    const int corners[] = {place_of(t[0]), place_of(t[1]), place_of(t[2])};
    for (size_t k = 0; k < 3; ++k) {
      const int a = corners[k], b = corners[(k + 1) % 3];
      edges[std::minmax(a, b)] += a < b ? 1 : -1;
    }
  }
  size_t open = 0;
  for (const auto& [edge, balance] : edges) open += balance != 0;
  return open;
}

/// Area-weighted mean of the cosine between shading and geometric normals.
double agreement(const Mesh& mesh) {
  double sum = 0, area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Vec3 n = cross(mesh.positions[b] - mesh.positions[a], mesh.positions[c] - mesh.positions[a]);
    for (const uint32_t i : {a, b, c}) sum += dot(n, mesh.normals[i]) / 3;
    area += length(n);
  }
  return sum / area;
}

void expect_sound(const Mesh& mesh) {
  ASSERT_FALSE(mesh.triangles.empty());
  ASSERT_TRUE(mesh.normals.empty() || mesh.normals.size() == mesh.positions.size());
  ASSERT_TRUE(mesh.uvs.empty() || mesh.uvs.size() == mesh.positions.size());
  for (const Vec3 p : mesh.positions) ASSERT_TRUE(std::isfinite(p.x + p.y + p.z));
  for (const Vec3 n : mesh.normals) ASSERT_NEAR(length(n), 1, 1e-4);
  for (const Vec2 uv : mesh.uvs) ASSERT_TRUE(std::isfinite(uv.x + uv.y));
  for (const auto& t : mesh.triangles)
    for (const uint32_t i : t) ASSERT_LT(i, mesh.positions.size());
}

TEST(Shapes, EveryModelIsSoundWhateverItsParameters) {
  for (const ModelKind& kind : model_kinds()) {
    SCOPED_TRACE(kind.name);
    for (uint32_t draw = 0; draw < 8; ++draw) {
      SCOPED_TRACE(draw);
      RandomStream random(11, RandomPurpose::test, draw, 0, 0);
      const Model model = kind.make(random);
      ASSERT_FALSE(model.empty());
      size_t triangles = 0;
      float radius = 0;
      for (const Part& part : model) {
        expect_sound(part.mesh);
        triangles += part.mesh.triangles.size();
        radius = std::max(radius, radius_around(part.mesh.positions, {}));
        EXPECT_GT(agreement(part.mesh), 0.8);
        if (!part.closed) continue;
        EXPECT_EQ(open_edges(part.mesh), 0U);
        EXPECT_GT(volume(part.mesh), 0);
      }
      EXPECT_NEAR(radius, 1, 1e-3);
      EXPECT_LE(triangles, kind.family == Family::plant ? 50000U : 30000U);
    }
  }
}

TEST(Shapes, ModelsAreAFunctionOfTheirRandomNumbers) {
  for (const ModelKind& kind : model_kinds()) {
    SCOPED_TRACE(kind.name);
    const auto draw = [&](uint32_t index) {
      RandomStream random(5, RandomPurpose::test, index);
      std::vector<float> numbers;
      for (const Part& part : kind.make(random))
        for (const Vec3 p : part.mesh.positions) numbers.insert(numbers.end(), {p.x, p.y, p.z});
      return numbers;
    };
    EXPECT_EQ(draw(0), draw(0));
    std::set<std::vector<float>> different;
    for (uint32_t i = 0; i < 6; ++i) different.insert(draw(i));
    EXPECT_GT(different.size(), 2U) << "parameters are drawn";
  }
}

TEST(Shapes, NamesOfModelsDiffer) {
  std::set<std::string> names;
  std::set<Family> families;
  for (const ModelKind& kind : model_kinds()) {
    EXPECT_TRUE(names.insert(kind.name).second) << kind.name;
    families.insert(kind.family);
    EXPECT_GT(kind.likelihood, 0);
  }
  EXPECT_GE(names.size(), 60U);
  EXPECT_EQ(families.size(), 7U);
}

TEST(Shapes, VolumesAgreeWithTheirFormulas) {
  EXPECT_NEAR(volume(make_block({1, 2, 3}, {0.5F, 1, 2})), 8, 1e-5);
  // The bevel takes a ring of triangular cross-section, 0.04 wide and high, at both ends.
  const double bevel = 2 * kPi * (1 - 0.04 / 3) * 0.0008 * 2;
  EXPECT_NEAR(volume(make_cylinder(1, 1, 256)), 2 * kPi - bevel, 2e-3);
  EXPECT_NEAR(volume(make_capsule(0.5F, 0.4F, 256)), kPi * 0.16 + 4.0 / 3 * kPi * 0.064, 6e-3);
  EXPECT_NEAR(volume(make_superellipsoid(1, 1, 256)), 4.0 / 3 * kPi, 2e-3) << "exponents of 1: a ball";
  EXPECT_NEAR(volume(make_supertoroid(0.3F, 1, 1, 256)), 2 * kPi * kPi * 0.09, 2e-3);
  EXPECT_NEAR(volume(make_prism(star_outline(4, std::sqrt(0.5F)), 0.5F, 0, 1, 1)), 2, 1e-5)
      << "a square of side sqrt 2";
  EXPECT_NEAR(volume(make_rod({0, 0, 0}, {0, 2, 0}, 0.5F, 128)), 2 * kPi * 0.25, 2e-3);
  EXPECT_NEAR(volume(make_platonic(8)), 4.0 / 3, 1e-5);
  // Edges of length a: a^3 (15 + 7 sqrt 5) / 4, on the unit sphere a = 4 / (sqrt 3 (1 + sqrt 5)).
  const double a = 4 / (std::sqrt(3.0) * (1 + std::sqrt(5.0)));
  EXPECT_NEAR(volume(make_platonic(12)), a * a * a * (15 + 7 * std::sqrt(5.0)) / 4, 1e-4);
  EXPECT_NEAR(volume(make_level_set([](Vec3 p) { return 0.8F - length(p); }, 48)), 4.0 / 3 * kPi * 0.512,
              0.02);
  EXPECT_NEAR(volume(make_voxels(3, 2, 1, [](int x, int y, int) { return x != 1 || y == 0; })), 5, 1e-5);
  const double r = 0.2, core = (2 - 2 * r) * (2 - 2 * r) * (2 - 2 * r);
  const double rounded =
      core + 6 * (2 - 2 * r) * (2 - 2 * r) * r + 3 * kPi * r * r * (2 - 2 * r) + 4.0 / 3 * kPi * r * r * r;
  EXPECT_NEAR(volume(make_rounded_box({1, 1, 1}, 0.2F)), rounded, 0.03);
}

TEST(MeshTools, CreasesSeparateAndSmoothEdgesShareNormals) {
  Mesh box = make_block({}, grey(1));
  shade(box, 0.5F);
  EXPECT_EQ(box.positions.size(), 24U) << "a right angle stays sharp";
  for (const Vec3 n : box.normals)
    EXPECT_NEAR(max_component({std::abs(n.x), std::abs(n.y), std::abs(n.z)}), 1, 1e-6);
  shade(box, kPi);
  for (size_t i = 0; i < box.positions.size(); ++i)
    EXPECT_GT(dot(box.normals[i], normalize(box.positions[i])), 0.9F) << "smooth: towards the corner";
}

TEST(MeshTools, AppendKeepsWhatBothHave) {
  Mesh mesh = make_sphere(1);
  append(mesh, make_block({3, 0, 0}, grey(1)));
  EXPECT_TRUE(mesh.uvs.empty()) << "the sphere has no texture coordinates";
  EXPECT_EQ(mesh.normals.size(), mesh.positions.size());
  EXPECT_EQ(mesh.triangles.size(), 80U + 12);
  Mesh flat = make_box();
  append(flat, make_sphere(1));
  ASSERT_EQ(flat.normals.size(), flat.positions.size()) << "the flat box got its normals";
  EXPECT_GT(agreement(flat), 0.9);
}

TEST(MeshTools, TurnsAboutAnAxis) {
  const Vec3 turned = turned_about({0, 1, 0}, 0.5F * kPi).to_world({0, 0, 1});
  EXPECT_NEAR(turned.x, 1, 1e-6);
  EXPECT_NEAR(turned.z, 0, 1e-6);
}

}  // namespace
}  // namespace ld
