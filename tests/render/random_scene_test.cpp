// Random scenes: seeded, varied, renderable.
#include "render/random/random_scene.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>

#include "core/file_io.h"
#include "render/recipe/contact_sheet.h"
#include "render/trace/image_renderer.h"
#include "tests/support/expect_error.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

/// Full variety with few objects, so that tests are quick.
SceneConfig few_objects() {
  SceneConfig config;
  config.objects = {5, 9};
  return config;
}

SceneConfig simple_scenes() {
  SceneConfig config;
  config.variety = "simple";
  return config;
}

RenderSettings settings_for(uint64_t seed, uint32_t frame, int spp, int threads) {
  RenderSettings settings;
  settings.seed = seed;
  settings.frame = frame;
  settings.spp = spp;
  settings.threads = threads;
  return settings;
}

bool starts_with(const std::string& text, const std::string& start) {
  return text.rfind(start, 0) == 0;
}

TEST(RandomScene, SharesAndVarietyOfSimpleScenes) {
  const SceneConfig config = simple_scenes();
  int indoor = 0, defocus = 0, motion = 0;
  std::set<int> kinds, patterns;
  constexpr int kScenes = 200;
  for (uint32_t frame = 0; frame < kScenes; ++frame) {
    const Scene scene = random_scene(config, 1, frame, 0, 64, 64);
    const bool is_indoor = starts_with(scene.name, "indoor");
    indoor += is_indoor;
    EXPECT_EQ(is_indoor, !scene.sky.has_value());
    EXPECT_EQ(is_indoor, !scene.lights.empty());
    defocus += scene.camera.lens_radius > 0;
    const bool moves = std::any_of(scene.objects.begin(), scene.objects.end(),
                                   [](const Object& object) { return !object.motion.still(); });
    motion += scene.camera.shutter;
    EXPECT_FALSE(moves && !scene.camera.shutter);
    for (const Material& material : scene.materials) {
      kinds.insert(static_cast<int>(material.kind));
      patterns.insert(static_cast<int>(material.colour.pattern));
    }
    // 30 at most, and floor, walls and the backs of four lamps.
    EXPECT_GE(scene.objects.size(), 7U);
    EXPECT_LE(scene.objects.size(), 40U);
  }
  EXPECT_EQ(indoor, kScenes / 2);
  // Four standard deviations of 200 fair coins.
  EXPECT_NEAR(defocus, 100, 28);
  EXPECT_NEAR(motion, 100, 28);
  EXPECT_EQ(kinds.size(), 5U);
  EXPECT_EQ(patterns.size(), 7U);
}

TEST(RandomScene, VarietyOfFullScenes) {
  SceneConfig config = few_objects();
  config.motion_blur = 1;
  std::set<int> kinds, patterns;
  std::map<std::string, int> places;
  int turning = 0, sliding = 0, moving_cameras = 0, point_lights = 0, skies = 0, probes = 0, lamps = 0,
      cut_outs = 0;
  constexpr int kScenes = 120;
  for (uint32_t frame = 0; frame < kScenes; ++frame) {
    const Scene scene = random_scene(config, 1, frame, 0, 64, 64);
    ++places[scene.name.substr(0, scene.name.find(", ", scene.name.find(", ") + 2))];
    EXPECT_LE(scene.lights.size(), 4U) << scene.name;
    EXPECT_LE(scene.point_lights.size(), 1U) << scene.name;
    EXPECT_FALSE(scene.sky && scene.probe);
    EXPECT_TRUE(scene.sky || scene.probe) << "windows look out on something";
    point_lights += !scene.point_lights.empty();
    skies += scene.sky.has_value();
    probes += scene.probe.has_value();
    moving_cameras += scene.camera.close.has_value();
    for (const Object& object : scene.objects) {
      turning += object.motion.angle != 0;
      sliding += !is_black(object.motion.translation);
    }
    for (const Material& material : scene.materials) {
      kinds.insert(static_cast<int>(material.kind));
      patterns.insert(static_cast<int>(material.colour.pattern));
      lamps += material.emission.has_value();
      cut_outs += material.opacity.has_value();
    }
  }
  EXPECT_EQ(places.size(), SceneConfig::room_names().size() + SceneConfig::backdrop_names().size());
  EXPECT_EQ(SceneConfig::room_names().size(), 8U);
  EXPECT_EQ(kinds.size(), 8U) << "all kinds of material";
  EXPECT_EQ(patterns.size(), 15U) << "all patterns but pictures, which come from the user's files";
  EXPECT_GT(turning, 40);
  EXPECT_GT(sliding, 40);
  // Four standard deviations of 120 coins that fall on one side in four.
  EXPECT_NEAR(moving_cameras, 30, 19);
  EXPECT_GT(point_lights, 15);
  EXPECT_GT(skies, 20);
  EXPECT_GT(probes, 20);
  EXPECT_GT(lamps, 5);
  EXPECT_GT(cut_outs, 2);
}

TEST(RandomScene, KindsOfPlacesCanBeChosen) {
  SceneConfig config = few_objects();
  config.rooms = {"attic", "kitchen"};
  config.backdrops = {"steps"};
  std::set<std::string> names;
  for (uint32_t frame = 0; frame < 12; ++frame) {
    config.defocus = config.motion_blur = 0;
    names.insert(random_scene(config, 1, frame, 0, 8, 8).name);
  }
  EXPECT_EQ(names, (std::set<std::string>{"indoor, attic", "indoor, kitchen", "outdoor, steps"}));
}

TEST(RandomScene, ShareOfRoomsIsKeptExactly) {
  SceneConfig config = simple_scenes();
  config.indoor = 0.25;
  int indoor = 0;
  for (uint32_t frame = 0; frame < 40; ++frame)
    indoor += starts_with(random_scene(config, 1, frame, 0, 8, 8).name, "indoor");
  EXPECT_EQ(indoor, 10);
}

TEST(RandomScene, FramesAreBitIdenticalWhateverTheThreads) {
  for (const SceneConfig& config : {simple_scenes(), few_objects()})
    for (const uint32_t frame : {0U, 1U}) {
      const auto scene = prepare_random_scene(config, 3, frame, 24, 20);
      const Frame one = *render_samples(*scene, settings_for(3, frame, 2, 1));
      const Image reference = *render_reference(*scene, settings_for(3, frame, 4, 1));
      for (const int threads : {2, 3}) {
        const auto again = prepare_random_scene(config, 3, frame, 24, 20);
        EXPECT_EQ(render_samples(*again, settings_for(3, frame, 2, threads))->samples, one.samples);
        EXPECT_EQ(render_reference(*again, settings_for(3, frame, 4, threads))->pixels, reference.pixels);
      }
    }
}

TEST(RandomScene, SeedsFramesAndPurposesDiffer) {
  const SceneConfig config = simple_scenes();
  const auto picture = [&](uint64_t seed, uint32_t frame) {
    return render_samples(*prepare_random_scene(config, seed, frame, 16, 16), settings_for(seed, frame, 1, 1))
        ->samples;
  };
  const auto base = picture(1, 0);
  EXPECT_EQ(picture(1, 0), base);
  EXPECT_NE(picture(2, 0), base);
  EXPECT_NE(picture(1, 2), base);
  // One and the same scene: the reference's samples are others than the frame's.
  const auto scene = prepare_random_scene(config, 1, 1, 16, 16);
  const Image input = mean_radiance(*render_samples(*scene, settings_for(1, 1, 4, 1)));
  const Image reference = *render_reference(*scene, settings_for(1, 1, 4, 1));
  size_t different = 0;
  for (size_t i = 0; i < input.pixels.size(); ++i) different += input.pixels[i] != reference.pixels[i];
  EXPECT_GT(different, input.pixels.size() * 9 / 10);
}

void expect_sound_and_well_exposed(const SceneConfig& config, uint32_t frame) {
  const auto scene = prepare_random_scene(config, 9, frame, 24, 24);
  const Frame samples = *render_samples(*scene, settings_for(9, frame, 8, 2));
  int64_t bad = 0, negative = 0;
  for (const float value : samples.samples) bad += !std::isfinite(value);
  for (int s = 0; s < samples.spp; ++s)
    for (int c = 0; c < 3; ++c)
      for (size_t p = 0; p < samples.plane_size(); ++p) negative += samples.plane(s, c)[p] < 0;
  EXPECT_EQ(bad, 0);
  EXPECT_EQ(negative, 0);
  std::vector<float> luminances;
  const Image mean = mean_radiance(samples);
  for (size_t p = 0; p < mean.plane_size(); ++p)
    luminances.push_back(luminance({mean.plane(0)[p], mean.plane(1)[p], mean.plane(2)[p]}));
  const auto middle = luminances.begin() + static_cast<std::ptrdiff_t>(luminances.size() / 2);
  std::nth_element(luminances.begin(), middle, luminances.end());
  EXPECT_GT(*middle, 0.04F);
  EXPECT_LT(*middle, 1.0F);
  for (int s = 0; s < samples.spp; ++s)
    for (size_t p = 0; p < samples.plane_size(); ++p) {
      const Vec3 n = {samples.plane(s, 3)[p], samples.plane(s, 4)[p], samples.plane(s, 5)[p]};
      const bool escaped = samples.plane(s, kDepthOffset)[p] == kEscapedDepth;
      ASSERT_NEAR(length(n), escaped ? 0 : 1, 1e-4);
      ASSERT_GT(samples.plane(s, kDepthOffset)[p], 0);
    }
}

TEST(RandomScene, PicturesAreSoundAndWellExposed) {
  for (uint32_t frame = 0; frame < 10; ++frame) {
    SCOPED_TRACE(frame);
    expect_sound_and_well_exposed(simple_scenes(), frame);
    expect_sound_and_well_exposed(few_objects(), frame);
  }
}

TEST(RandomScene, DraftsWithoutAPictureAreFound) {
  Scene scene;
  scene.camera.width = scene.camera.height = 32;
  scene.objects.push_back({make_box(), 0, {}});
  scene.materials.push_back({});
  scene.camera.position = {0, 0, 1.2F};
  EXPECT_EQ(look_at_draft(PreparedScene(scene), 0.3F, 1, 0, 0).fault, DraftFault::too_close);
  scene.camera.position = {0, 0, 40};
  EXPECT_EQ(look_at_draft(PreparedScene(scene), 0.3F, 1, 0, 0).fault, DraftFault::empty);
  scene.camera.position = {0, 0, 4};
  EXPECT_EQ(look_at_draft(PreparedScene(scene), 0.3F, 1, 0, 0).fault, DraftFault::black) << "no light";
  scene.sky = Sky{};
  EXPECT_EQ(look_at_draft(PreparedScene(scene), 0.3F, 1, 0, 0).fault, DraftFault::monotonous) << "one object";
  scene.materials[0].kind = MaterialKind::smooth_dielectric;
  EXPECT_EQ(look_at_draft(PreparedScene(scene), 0.3F, 1, 0, 0).fault, DraftFault::glassy);
  scene.camera.position = {0, 0, 0.3F};
  EXPECT_EQ(look_at_draft(PreparedScene(scene), 0.3F, 1, 0, 0).fault, DraftFault::inside);
}

TEST(RandomScene, StopsWhenAsked) {
  const auto scene = prepare_random_scene(simple_scenes(), 1, 0, 16, 16);
  RenderSettings settings = settings_for(1, 0, 1, 2);
  settings.stop = [] { return true; };
  EXPECT_FALSE(render_samples(*scene, settings).has_value());
  EXPECT_FALSE(render_reference(*scene, settings).has_value());
}

TEST(SceneConfig, SurvivesBeingWritten) {
  SceneConfig config = few_objects();
  config.rooms = {"living room", "attic"};
  config.outdoor_objects = {3, 4};
  const auto again = config_from_tree<SceneConfig>(parse_config(config_to_yaml(config), "test"));
  EXPECT_EQ(config_to_yaml(again), config_to_yaml(config));
  EXPECT_EQ(again.rooms, config.rooms);
}

class OwnFiles : public ::testing::Test {
 protected:
  OwnFiles() {
    // Written in an order that is not that of their names.
    for (const char* name : {"b.ply", "a.ply"})
      write_file_atomically(
          folder_.path() / name,
          "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
          "element face 4\nproperty list uchar int vertex_indices\nend_header\n"
          "0 0 0\n4 0 0\n0 4 0\n0 0 4\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
    config_ = few_objects();
    config_.meshes = folder_.path().string();
    config_.own_files = 1;
    config_.indoor = 0;  // a room of so few models holds only its furniture
  }
  TemporaryFolder folder_;
  SceneConfig config_;
};

TEST_F(OwnFiles, AreUsedAndCheckedByTheirBytes) {
  finish_scene_config(config_, "recipe", ".");
  EXPECT_FALSE(config_.files.empty());
  const Scene scene = random_scene(config_, 1, 1, 0, 8, 8);
  const bool used = std::any_of(scene.objects.begin(), scene.objects.end(),
                                [](const Object& object) { return object.mesh.triangles.size() == 4; });
  EXPECT_TRUE(used);
  SceneConfig other = config_;
  other.files = "0123456789abcdef";
  EXPECT_ERROR(finish_scene_config(other, "recipe", "."),
               "expected files with the checksum 0123456789abcdef");
}

TEST_F(OwnFiles, MissingFoldersAreNamed) {
  config_.textures = "/nonexistent/pictures";
  EXPECT_ERROR(finish_scene_config(config_, "recipe", "."), "/nonexistent/pictures: no such folder");
  config_.textures = folder_.path().string();
  EXPECT_ERROR(finish_scene_config(config_, "recipe", "."), "found none");
}

TEST(SceneConfig, CountsComeInPairs) {
  SceneConfig config;
  config.outdoor_objects = {9, 3};
  EXPECT_ERROR(finish_scene_config(config, "recipe", "."), "swap them");
  config.outdoor_objects = {9};
  EXPECT_ERROR(finish_scene_config(config, "recipe", "."), "outdoor_objects");
}

TEST(ContactSheet, ShowsTheScenesOfARecipe) {
  const TemporaryFolder folder;
  Recipe recipe;
  recipe.resolution = {24, 16};
  recipe.scenes = simple_scenes();
  const SheetReport report = render_contact_sheet(recipe, 0, 5, 3, 2, folder.path() / "sheet.png", 2);
  EXPECT_EQ(report.scenes, 5);
  EXPECT_GE(report.drafts, 5);
  int64_t rejected = 0;
  for (const auto& [fault, count] : report.rejected) rejected += count;
  EXPECT_EQ(report.drafts - report.scenes, rejected);
  const auto sheet = read_texture_image(folder.path() / "sheet.png", TextureUse::colour);
  EXPECT_EQ(sheet->width, 3 * 24 + 2 * 2);
  EXPECT_EQ(sheet->height, 2 * 16 + 2);
  float brightest = 0;
  for (const Vec3 texel : sheet->texels) brightest = std::max(brightest, luminance(texel));
  EXPECT_GT(brightest, 0.1F);
}

}  // namespace
}  // namespace ld
