// The catalogue of models.
#include "render/geometry/mesh_tools.h"
#include "render/random/shapes/furniture.h"
#include "render/random/shapes/shapes.h"

namespace ld {
namespace {

Model one(Mesh mesh, Stuff stuff = Stuff::any, bool closed = true) {
  Model model;
  model.push_back({std::move(mesh), stuff, closed});
  return model;
}

Model of_plant(Plant plant, Stuff stems = Stuff::wood) {
  Model model;
  if (!plant.stems.positions.empty()) model.push_back({std::move(plant.stems), stems, true});
  if (!plant.leaves.positions.empty()) model.push_back({std::move(plant.leaves), Stuff::leaf, false});
  return model;
}

/// Stretches by up to `most` along each axis.
Model stretched(Model model, RandomStream& random, float most) {
  const Vec3 scale = {random.uniform(1 / most, 1), random.uniform(1 / most, 1), random.uniform(1 / most, 1)};
  place(model, scale, {}, {});
  return model;
}

Model ball(RandomStream& random) {
  return random.below(3) == 0 ? stretched(one(make_sphere(4)), random, 2) : one(make_sphere(4));
}

Model box(RandomStream& random) {
  return stretched(one(make_block({}, grey(1))), random, 3);
}

Model ring(RandomStream& random) {
  const float tube = random.uniform(0.1F, 0.45F), north = random.uniform(0.3F, 1.8F),
              east = random.uniform(0.4F, 1.3F);
  return one(random.below(2) == 0 ? make_torus(tube, 64, 24) : make_supertoroid(tube, north, east, 96));
}

Model blob(RandomStream& random) {
  const float amplitude = random.uniform(0.15F, 0.6F), frequency = random.uniform(0.8F, 2.5F);
  const int octaves = 1 + static_cast<int>(random.below(3));
  return one(make_blob(amplitude, frequency, octaves, random.bits(), 4));
}

Model cylinder(RandomStream& random) {
  constexpr float kTops[] = {1, 1, 0, 0.5F, 0.8F};
  const float half = random.uniform(0.1F, 2.5F);
  return one(make_cylinder(half, kTops[random.below(5)], 48));
}

Model capsule(RandomStream& random) {
  const float half = random.uniform(0.2F, 1.2F);
  return one(make_capsule(half, random.uniform(0.2F, 0.6F), 40));
}

Model rounded_box(RandomStream& random) {
  const Vec3 half = {random.uniform(0.3F, 1), random.uniform(0.3F, 1), random.uniform(0.3F, 1)};
  return one(make_rounded_box(half, random.uniform(0.03F, 0.28F)));
}

Model prism(RandomStream& random) {
  const int sides = 3 + static_cast<int>(random.below(6));
  const float half = random.uniform(0.1F, 1.5F),
              twist = random.below(3) == 0 ? random.uniform(-2.5F, 2.5F) : 0;
  const float taper = random.uniform(0.4F, 1);
  return one(make_prism(star_outline(sides, std::cos(kPi / static_cast<float>(sides))), half, twist, taper,
                        twist != 0 ? 40 : 1));
}

Model star(RandomStream& random) {
  const int points = 4 + static_cast<int>(random.below(9));
  const float inner = random.uniform(0.3F, 0.8F), half = random.uniform(0.06F, 1.2F);
  const float twist = random.below(2) == 0 ? random.uniform(-2, 2) : 0, taper = random.uniform(0.3F, 1);
  return one(make_prism(star_outline(points, inner), half, twist, taper, twist != 0 ? 40 : 1));
}

Model gear(RandomStream& random) {
  const int teeth = 8 + static_cast<int>(random.below(28));
  const float depth = random.uniform(0.1F, 0.3F), half = random.uniform(0.05F, 0.6F);
  const float twist = random.below(3) == 0 ? random.uniform(-0.6F, 0.6F) : 0;
  return one(make_prism(gear_outline(teeth, depth), half, twist, 1, twist != 0 ? 12 : 1), Stuff::metal);
}

Model platonic(RandomStream& random) {
  constexpr int kFaces[] = {4, 6, 8, 12, 20};
  return one(make_platonic(kFaces[random.below(5)]));
}

Model superellipsoid(RandomStream& random) {
  const float north = random.uniform(0.2F, 2.4F), east = random.uniform(0.2F, 2.4F);
  return stretched(one(make_superellipsoid(north, east, 96)), random, 1.8F);
}

Model supershape(RandomStream& random) {
  const auto formula = [&] {
    SuperFormula f;
    f.m = static_cast<float>(2 * (1 + random.below(6)));
    f.n1 = random.uniform(0.5F, 4);
    f.n2 = random.uniform(0.5F, 4);
    f.n3 = f.n2;
    return f;
  };
  const SuperFormula around = formula(), upwards = formula();
  return one(make_supershape(around, upwards, 120));
}

Model seashell(RandomStream& random) {
  const float turns = random.uniform(2.5F, 5), growth = random.uniform(1.2F, 2.4F);
  return one(make_seashell(turns, growth, std::floor(random.uniform(0, 40))));
}

Model gyroid(RandomStream& random) {
  const float scale = random.uniform(2.6F, 4.2F), wall = random.uniform(0.3F, 0.9F);
  const bool round = random.below(2) == 0;
  return one(make_level_set(
      [=](Vec3 p) {
        const Vec3 q = p * scale;
        const float g =
            std::sin(q.x) * std::cos(q.y) + std::sin(q.y) * std::cos(q.z) + std::sin(q.z) * std::cos(q.x);
        const float hull = round ? 0.95F - length(p)
                                 : 0.93F - std::max(std::abs(p.x), std::max(std::abs(p.y), std::abs(p.z)));
        return std::min(wall - std::abs(g), scale * hull);
      },
      21));
}

Model metaballs(RandomStream& random) {
  std::vector<std::pair<Vec3, float>> balls;
  const int count = 4 + static_cast<int>(random.below(8));
  for (int i = 0; i < count; ++i) {
    const Vec3 at = {random.uniform(-0.55F, 0.55F), random.uniform(-0.55F, 0.55F),
                     random.uniform(-0.55F, 0.55F)};
    balls.emplace_back(at, random.uniform(0.15F, 0.3F));
  }
  return one(make_level_set(
      [&](Vec3 p) {
        float sum = -1;
        for (const auto& [at, r] : balls) sum += r * r / (dot(p - at, p - at) + 1e-4F);
        return sum;
      },
      28));
}

Model sponge(RandomStream& random) {
  if (random.below(2) == 0)  // Menger's
    return one(make_voxels(9, 9, 9, [](int x, int y, int z) {
      for (int k = 0; k < 2; ++k) {
        if ((x % 3 == 1) + (y % 3 == 1) + (z % 3 == 1) >= 2) return false;
        x /= 3, y /= 3, z /= 3;
      }
      return true;
    }));
  std::vector<bool> filled;  // every cell by the flip of a coin, mirrored
  for (int i = 0; i < 4 * 8 * 8; ++i) filled.push_back(random.uniform() < 0.45F);
  return one(make_voxels(
      8, 8, 8, [&](int x, int y, int z) { return filled[(z * 8 + y) * 4 + std::min(x, 7 - x)] || y == 0; }));
}

Model skyline(RandomStream& random) {
  Model model;
  const int side = 3 + static_cast<int>(random.below(4));
  for (int i = 0; i < side; ++i)
    for (int k = 0; k < side; ++k) {
      const float half = random.uniform(0.25F, 0.45F), h = 0.3F + 2.5F * std::pow(random.uniform(), 2.5F);
      constexpr Stuff kWalls[] = {Stuff::stone, Stuff::any, Stuff::metal};
      add_part(model, kWalls[random.below(3)],
               make_block({static_cast<float>(i), h, static_cast<float>(k)}, {half, h, half}));
    }
  return model;
}

Model helix(RandomStream& random) {
  const float turns = random.uniform(3, 12), radius = random.uniform(0.25F, 0.9F),
              height = random.uniform(0.5F, 2.2F);
  return one(make_helix(turns, radius, height, random.uniform(0.02F, 0.09F)), Stuff::metal);
}

Model knot(RandomStream& random) {
  constexpr int kKnots[][2] = {{2, 3}, {3, 2}, {2, 5}, {3, 4}, {5, 2}, {3, 5}, {4, 5}, {5, 3}, {3, 7}};
  const auto& [p, q] = kKnots[random.below(9)];
  return one(make_torus_knot(p, q, random.uniform(0.05F, 0.16F)));
}

Model cables(RandomStream& random) {
  return one(make_cables(random, 3 + static_cast<int>(random.below(14))));
}
Model chain(RandomStream& random) {
  return one(make_chain(random, 16 + static_cast<int>(random.below(30))), Stuff::metal);
}
Model rope(RandomStream& random) {
  return one(make_rope(random), Stuff::cloth);
}

Model wire_sphere(RandomStream& random) {
  const int levels = 1 + static_cast<int>(random.below(2));
  return one(make_wire_sphere(levels, random.uniform(0.01F, 0.035F)), Stuff::metal);
}

Model grille(RandomStream& random) {
  const int columns = 4 + static_cast<int>(random.below(12)), rows = 4 + static_cast<int>(random.below(12));
  const float bar = random.uniform(0.08F, 0.3F) / static_cast<float>(std::max(columns, rows));
  return one(make_grille(columns, rows, bar, random.below(2) == 0));
}

Model lattice(RandomStream& random) {
  const int cells = 1 + static_cast<int>(random.below(5));
  return stretched(one(make_lattice(cells, random.uniform(0.03F, 0.2F) / static_cast<float>(cells))), random,
                   1.5F);
}

Model fence(RandomStream& random) {
  return one(make_fence(random), Stuff::wood);
}
Model ladder(RandomStream& random) {
  return one(make_ladder(5 + static_cast<int>(random.below(8))), Stuff::wood);
}
Model curtain(RandomStream& random) {
  return one(make_curtain(random), Stuff::cloth, false);
}
Model draped_sheet(RandomStream& random) {
  return one(make_draped_sheet(random), Stuff::cloth, false);
}
Model flag(RandomStream& random) {
  return one(make_flag(random), Stuff::cloth, false);
}
Model crumpled_sheet(RandomStream& random) {
  return one(make_crumpled_sheet(random), Stuff::paper, false);
}
Model ribbon(RandomStream& random) {
  return one(make_ribbon(random), Stuff::cloth, false);
}
Model rock(RandomStream& random) {
  return one(make_rock(random), Stuff::stone);
}
Model crystals(RandomStream& random) {
  const Stuff stuff = random.below(2) == 0 ? Stuff::glass : Stuff::any;
  return one(make_crystals(random), stuff);
}
Model land(RandomStream& random) {
  return one(make_terrain_block(random), Stuff::stone);
}
Model grass(RandomStream& random) {
  return of_plant(make_grass(random));
}
Model fern(RandomStream& random) {
  return of_plant(make_fern(random), Stuff::leaf);
}
Model bush(RandomStream& random) {
  return of_plant(make_bush(random));
}
Model tree(RandomStream& random) {
  return of_plant(make_tree(random));
}
Model flower(RandomStream& random) {
  return of_plant(make_flower(random), Stuff::leaf);
}

Model potted_plant(RandomStream& random) {
  const uint32_t kind = random.below(4);
  const Plant plant = kind == 0   ? make_fern(random)
                      : kind == 1 ? make_flower(random)
                                  : make_potted_plant(random);
  Model model = of_plant(plant);
  const float width = random.uniform(0.2F, 0.4F), height = random.uniform(0.25F, 0.6F),
              foot = width * random.uniform(0.6F, 1);
  const float rim = 1.06F * width;
  add_part(model, Stuff::ceramic,
           moved(make_lathe({{0, 0},
                             {foot, 0},
                             {width, 0.85F * height},
                             {rim, 0.86F * height},
                             {rim, height},
                             {0.9F * width, height},
                             {0.85F * width, 0.85F * height},
                             {0, 0.85F * height}},
                            40),
                 {0, -height, 0}));
  return model;
}

template <Model (*make)(RandomStream&)>
Model fitted(RandomStream& random) {
  Model model = make(random);
  fit_to_unit(model);
  return model;
}

template <Model (*make)(RandomStream&)>
ModelKind kind(const char* name, Family family, bool upright, float likelihood) {
  return {name, family, upright, likelihood, fitted<make>};
}

}  // namespace

const std::vector<ModelKind>& model_kinds() {
  static const std::vector<ModelKind> kinds = {
      kind<ball>("ball", Family::solid, false, 1),
      kind<box>("box", Family::solid, true, 1),
      kind<ring>("ring", Family::solid, false, 1),
      kind<blob>("blob", Family::solid, false, 1),
      kind<cylinder>("cylinder", Family::solid, true, 0.8F),
      kind<capsule>("capsule", Family::solid, false, 0.5F),
      kind<rounded_box>("rounded box", Family::solid, true, 0.8F),
      kind<prism>("prism", Family::solid, true, 0.6F),
      kind<star>("star", Family::solid, true, 0.6F),
      kind<gear>("gear", Family::solid, false, 0.6F),
      kind<platonic>("platonic solid", Family::solid, false, 0.6F),
      kind<superellipsoid>("superellipsoid", Family::solid, false, 0.6F),
      kind<supershape>("supershape", Family::solid, false, 0.8F),
      kind<seashell>("seashell", Family::solid, false, 0.5F),
      kind<gyroid>("gyroid", Family::solid, false, 0.5F),
      kind<metaballs>("metaballs", Family::solid, false, 0.5F),
      kind<sponge>("sponge", Family::solid, true, 0.5F),
      kind<skyline>("skyline", Family::solid, true, 0.4F),
      kind<helix>("helix", Family::wire, false, 0.6F),
      kind<knot>("torus knot", Family::wire, false, 0.8F),
      kind<cables>("cables", Family::wire, false, 0.6F),
      kind<chain>("chain", Family::wire, false, 0.5F),
      kind<rope>("rope", Family::wire, false, 0.4F),
      kind<wire_sphere>("wire sphere", Family::wire, false, 0.6F),
      kind<grille>("grille", Family::wire, false, 0.6F),
      kind<lattice>("lattice", Family::wire, true, 0.6F),
      kind<fence>("fence", Family::wire, true, 0.5F),
      kind<ladder>("ladder", Family::wire, true, 0.3F),
      kind<curtain>("curtain", Family::sheet, true, 0.7F),
      kind<draped_sheet>("draped sheet", Family::sheet, true, 0.8F),
      kind<flag>("flag", Family::sheet, false, 0.5F),
      kind<crumpled_sheet>("crumpled sheet", Family::sheet, false, 0.6F),
      kind<ribbon>("ribbon", Family::sheet, false, 0.5F),
      kind<rock>("rock", Family::nature, true, 1),
      kind<crystals>("crystals", Family::nature, true, 0.5F),
      kind<land>("land", Family::nature, true, 0.3F),
      kind<grass>("grass", Family::plant, true, 0.8F),
      kind<fern>("fern", Family::plant, true, 0.6F),
      kind<bush>("bush", Family::plant, true, 0.8F),
      kind<tree>("tree", Family::plant, true, 1.2F),
      kind<flower>("flower", Family::plant, true, 0.6F),
      kind<potted_plant>("potted plant", Family::plant, true, 1),
      kind<make_table>("table", Family::furniture, true, 1),
      kind<make_chair>("chair", Family::furniture, true, 1.2F),
      kind<make_stool>("stool", Family::furniture, true, 0.6F),
      kind<make_sofa>("sofa", Family::furniture, true, 0.8F),
      kind<make_bed>("bed", Family::furniture, true, 0.4F),
      kind<make_cabinet>("cabinet", Family::furniture, true, 0.8F),
      kind<make_bookshelf>("bookshelf", Family::furniture, true, 1),
      kind<make_stairs>("stairs", Family::furniture, true, 0.4F),
      kind<make_spiral_stairs>("spiral stairs", Family::furniture, true, 0.3F),
      kind<make_floor_lamp>("floor lamp", Family::fixture, true, 0.6F),
      kind<make_desk_lamp>("desk lamp", Family::fixture, true, 0.5F),
      kind<make_chandelier>("chandelier", Family::fixture, true, 0.2F),
      kind<make_window_blinds>("window blinds", Family::fixture, true, 0.4F),
      kind<make_picture>("picture", Family::fixture, true, 0.5F),
      kind<make_monitor>("monitor", Family::fixture, true, 0.5F),
      kind<make_radiator>("radiator", Family::fixture, true, 0.4F),
      kind<make_candles>("candles", Family::fixture, true, 0.4F),
      kind<make_pipes>("pipes", Family::fixture, false, 0.5F),
      kind<make_wheel>("wheel", Family::fixture, false, 0.5F),
      kind<make_umbrella>("umbrella", Family::fixture, true, 0.4F),
      kind<make_vase>("vase", Family::fixture, true, 1),
      kind<make_bottle>("bottle", Family::fixture, true, 0.8F),
      kind<make_goblet>("goblet", Family::fixture, true, 0.6F),
      kind<make_bowl>("bowl", Family::fixture, true, 0.6F),
      kind<make_fruit_bowl>("fruit bowl", Family::fixture, true, 0.5F),
      kind<make_jug>("jug", Family::fixture, true, 0.6F),
      kind<make_column>("column", Family::fixture, true, 0.5F),
      kind<make_pawn>("pawn", Family::fixture, true, 0.8F),
      kind<make_plate_stack>("plate stack", Family::fixture, true, 0.4F),
      kind<make_box_stack>("box stack", Family::fixture, true, 0.6F),
      kind<make_book_stack>("book stack", Family::fixture, true, 0.6F),
      kind<make_coin_stack>("coin stack", Family::fixture, true, 0.3F),
      kind<make_crate>("crate", Family::fixture, true, 0.5F),
      kind<make_barrel>("barrel", Family::fixture, true, 0.5F),
  };
  return kinds;
}

}  // namespace ld
