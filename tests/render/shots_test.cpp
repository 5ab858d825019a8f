// The kinds of shots: what happens in each, seen by the guides.
#include "render/recipe/shots.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "render/random/stages.h"
#include "render/recipe/dataset_renderer.h"
#include "render/recipe/scene_source.h"
#include "render/trace/image_renderer.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

constexpr int64_t kLength = 8;

Recipe recipe_of(const std::string& kind) {
  Recipe recipe;
  recipe.seed = 5;
  recipe.resolution = {32, 18};
  recipe.frames = {0, 0, kLength, 0};
  recipe.filter_guides = true;
  recipe.spp = 2;
  recipe.scenes.objects = {4, 6};
  recipe.scenes.defocus = 0;
  recipe.sequence.length = kLength;
  recipe.sequence.shutter = 0;
  recipe.sequence.kinds = {kind};
  return recipe;
}

Frame frame_at(const SceneSource& source, int64_t position) {
  RenderSettings settings;
  settings.frame = static_cast<uint32_t>(position);
  settings.spp = 4;
  settings.filter_guides = true;
  settings.path.max_bounces = 3;
  return *render_samples(*source.prepare(position), settings);
}

double mean_brightness(const Frame& frame) {
  const Image mean = mean_radiance(frame);
  double sum = 0;
  for (const float value : mean.pixels) sum += value;
  return sum / static_cast<double>(mean.pixels.size());
}

/// The median length of flow over all samples, pixels.
double median_flow(const Frame& frame) {
  std::vector<double> lengths;
  for (int s = 0; s < frame.spp; ++s)
    for (size_t p = 0; p < frame.plane_size(); ++p)
      lengths.push_back(std::hypot(frame.plane(s, kFlowOffset)[p], frame.plane(s, kFlowOffset + 1)[p]));
  std::nth_element(lengths.begin(), lengths.begin() + static_cast<ptrdiff_t>(lengths.size() / 2),
                   lengths.end());
  return lengths[lengths.size() / 2];
}

TEST(Shots, EveryKindIsRenderedAndItsSequencesDiffer) {
  for (const std::string& kind : SequenceConfig::kind_names()) {
    SCOPED_TRACE(kind);
    const Recipe recipe = recipe_of(kind);
    const Shot a = plan_shot(recipe, 0), b = plan_shot(recipe, 1), again = plan_shot(recipe, 0);
    const Scene last = shot_frame(a, kLength - 1, 0.5F), same = shot_frame(again, kLength - 1, 0.5F),
                other = shot_frame(b, kLength - 1, 0.5F);
    ASSERT_EQ(last.objects.size(), same.objects.size());
    EXPECT_EQ(last.objects.back().mesh.positions[0].x, same.objects.back().mesh.positions[0].x);
    EXPECT_EQ(last.camera.position.x, same.camera.position.x);
    EXPECT_GT(length(last.camera.position - other.camera.position), 1e-3F);
    EXPECT_TRUE(kind == "fly" || last.name.find(kind) != std::string::npos) << last.name;
  }
}

TEST(Shots, ObjectsKeepTheirIdsBetweenCuts) {
  for (const std::string& kind : SequenceConfig::kind_names()) {
    const Shot shot = plan_shot(recipe_of(kind), 0);
    Scene before = shot_frame(shot, 0, 0);
    for (int64_t i = 1; i < kLength; ++i) {
      Scene now = shot_frame(shot, i, 0);
      if (!now.cut) {
        ASSERT_EQ(now.objects.size(), before.objects.size()) << kind;
        ASSERT_EQ(now.lights.size(), before.lights.size()) << kind;
        for (size_t k = 0; k < now.objects.size(); ++k) {
          ASSERT_EQ(now.objects[k].material, before.objects[k].material) << kind;
          // Where it says that the frame before had it.
          for (size_t v = 0; v < now.objects[k].mesh.positions.size(); v += 97) {
            const Vec3 then = now.objects[k].previous.point(now.objects[k].mesh.positions[v], 1);
            ASSERT_LT(length(then - before.objects[k].mesh.positions[v]), 1e-3F) << kind << " frame " << i;
          }
        }
        ASSERT_TRUE(now.camera.previous);
        EXPECT_LT(length(now.camera.previous->position - before.camera.position), 1e-4F) << kind;
      }
      before = std::move(now);
    }
  }
}

TEST(Shots, OnlyACutIsACut) {
  for (const std::string& kind : SequenceConfig::kind_names()) {
    const Shot shot = plan_shot(recipe_of(kind), 0);
    int cuts = 0;
    for (int64_t i = 0; i < kLength; ++i) cuts += shot_frame(shot, i, 0).cut ? 1 : 0;
    EXPECT_EQ(cuts, kind == "cut" ? 1 : 0) << kind;
    EXPECT_FALSE(shot_frame(shot, 0, 0).cut) << kind;
  }
}

TEST(Shots, FlowAfterACutLeadsNowhere) {
  const TemporaryFolder folder;
  Recipe recipe = recipe_of("cut");
  recipe.reference_spp.test = 1;
  render_dataset(recipe, folder.path(), 0, kLength, 2);
  int cuts = 0;
  for (const ManifestFrame& entry : read_manifest(folder.path()).frames) {
    Faults faults;
    const Frame frame = read_frame(frame_path(folder.path(), entry.name), {}, faults);
    EXPECT_TRUE(frame.info.world_to_camera);
    if (frame.info.cut) ++cuts;
    for (size_t p = 0; p < frame.plane_size(); ++p)
      EXPECT_EQ(frame.plane(0, kFlowOffset)[p] == kNoFlow, frame.info.cut);
  }
  EXPECT_EQ(cuts, 1);
}

TEST(Shots, LampsGoOutAtOnce) {
  const Recipe recipe = recipe_of("light_off");
  const auto source = make_scene_source(recipe);
  const Shot shot = plan_shot(recipe, 0);
  ASSERT_GT(shot.lamps_off, 0);
  ASSERT_LT(shot.lamps_off, kLength);
  const double before = mean_brightness(frame_at(*source, shot.lamps_off - 1)),
               after = mean_brightness(frame_at(*source, shot.lamps_off));
  EXPECT_LT(after, 0.5 * before);
  EXPECT_GT(after, 0);
}

TEST(Shots, AnOpeningDoorLetsLightIn) {
  const Recipe recipe = recipe_of("door");
  const auto source = make_scene_source(recipe);
  const Shot shot = plan_shot(recipe, 0);
  const Scene first = shot_frame(shot, 0, 0), second = shot_frame(shot, kDoorBegins, 0),
              third = shot_frame(shot, kDoorBegins + 1, 0), last = shot_frame(shot, kLength - 1, 0);
  size_t moved = 0;
  for (size_t i = 0; i < first.objects.size(); ++i) {
    const Vec3 at = first.objects[i].mesh.positions[0];
    EXPECT_EQ(length(second.objects[i].mesh.positions[0] - at), 0) << "closed until then";
    moved += length(third.objects[i].mesh.positions[0] - at) > 0.02F ? 1 : 0;
    EXPECT_LE(last.objects[i].mesh.positions[0].z, at.z + 0.05F)
        << "away from the camera, but for its thickness";
  }
  EXPECT_GE(moved, 1u);
  EXPECT_LE(moved, 2u) << "leaf and handle";
  EXPECT_GT(mean_brightness(frame_at(*source, kLength - 1)), 1.3 * mean_brightness(frame_at(*source, 0)));
}

TEST(Shots, ObjectsEnterFromOutside) {
  const Recipe recipe = recipe_of("enter");
  const auto source = make_scene_source(recipe);
  const size_t objects = source->prepare(0)->scene().objects.size();
  const auto seen = [&](int64_t position) {
    std::set<float> ids;
    const Frame frame = frame_at(*source, position);
    for (size_t p = 0; p < frame.plane_size(); ++p) ids.insert(frame.plane(0, kIdOffset)[p]);
    return ids;
  };
  const std::set<float> first = seen(0);
  size_t entered = 0;
  for (size_t k = objects - 3; k < objects; ++k) EXPECT_EQ(first.count(static_cast<float>(1 + k)), 0u);
  for (int64_t i = 2; i < kLength; ++i)
    for (size_t k = objects - 3; k < objects; ++k) entered += seen(i).count(static_cast<float>(1 + k));
  EXPECT_GE(entered, 4u);
}

TEST(Shots, CamerasMoveAsTheirNamesSay) {
  const auto camera = [](const std::string& kind, int64_t position) {
    return shot_frame(plan_shot(recipe_of(kind), 0), position, 0).camera;
  };
  Camera a = camera("dolly", 2), b = camera("dolly", 3);
  const Vec3 step = b.position - a.position;
  EXPECT_GT(length(step), 0.01F);
  EXPECT_NEAR(dot(normalize(step), -a.axes.z), 1, 1e-4);
  a = camera("turn", 2);
  b = camera("turn", 3);
  EXPECT_LT(length(b.position - a.position), 1e-5F);
  EXPECT_NEAR(dot(a.axes.y, b.axes.y), 1, 1e-5);
  const float degrees = std::acos(dot(a.axes.z, b.axes.z)) * 180 / kPi;
  EXPECT_GT(degrees, 1.4F);
  EXPECT_LT(degrees, 3.6F);
  for (const char* kind : {"mirror", "thin"}) {
    a = camera(kind, 2);
    b = camera(kind, 3);
    EXPECT_GT(length(b.position - a.position), 1e-3F) << kind;
    EXPECT_NEAR(std::abs(dot(normalize(b.position - a.position), a.axes.x)), 1, 1e-4) << kind;
  }
}

TEST(Shots, OfAStillOneOnlyTheNoiseIsNew) {
  const auto source = make_scene_source(recipe_of("still"));
  const Frame a = frame_at(*source, 3), b = frame_at(*source, 4);
  EXPECT_EQ(median_flow(a), 0);
  size_t same = 0;
  for (size_t p = 0; p < a.plane_size(); ++p) same += a.plane(0, 0)[p] == b.plane(0, 0)[p] ? 1 : 0;
  EXPECT_LT(same, a.plane_size() / 4);
  EXPECT_NEAR(mean_brightness(a) / mean_brightness(b), 1, 0.3);
  EXPECT_GT(median_flow(frame_at(*make_scene_source(recipe_of("turn")), 3)), 0.3);
}

TEST(Shots, KindsAreOfRandomScenes) {
  Recipe recipe = recipe_of("cut");
  finish_recipe(recipe, "recipe.yaml", "");
  recipe.scene_file.path = "scene.glb";
  EXPECT_ERROR(finish_recipe(recipe, "recipe.yaml", ""), "expected [fly] for a scene file, found [cut]");
  recipe.sequence.kinds = {};
  EXPECT_ERROR(finish_recipe(recipe, "recipe.yaml", ""), "at least one kind");
}

}  // namespace
}  // namespace ld
