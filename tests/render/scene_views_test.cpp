// Data sets from one scene file: which views there are, and ld_render from end to end.
#include "render/file/scene_views.h"

#include <gtest/gtest.h>

#include "core/file_io.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "render/recipe/dataset_renderer.h"
#include "render/recipe/scene_source.h"
#include "tests/render/test_gltf.h"
#include "tests/support/expect_error.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

const std::string kEngine = "/usr/share/assimp/models/glTF2/2CylinderEngine-glTF-Binary/2CylinderEngine.glb";
const std::string kBox = "/usr/share/assimp/models/glTF2/BoxTextured-glTF-Binary/BoxTextured.glb";

Recipe views_of(const std::string& scene, int64_t views, const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> small = {"resolution=[20,16]", "spp=2", "reference_spp.train=4",
                                    "reference_spp.validation=4", "reference_spp.test=4"};
  small.insert(small.end(), overrides.begin(), overrides.end());
  return scene_recipe(scene, "", views, small, {});
}

std::string bytes(const std::filesystem::path& folder, const std::string& name) {
  return read_file(frame_path(folder, name)) + read_file(reference_path(folder, name));
}

TEST(SceneRecipe, SplitsViewsAndTakesOverrides) {
  const Recipe one = views_of(kEngine, 0);
  EXPECT_EQ(one.frame_count(), 1) << "the file has one camera";
  EXPECT_EQ(one.split(0), "train");
  const Recipe many = views_of(kEngine, 24, {"spp=3"});
  EXPECT_EQ(many.frames.train, 18);
  EXPECT_EQ(many.frames.validation, 3);
  EXPECT_EQ(many.frames.test, 3);
  EXPECT_EQ(many.spp, 3);
  EXPECT_EQ(many.scene_file.checksum.size(), 16U);
  EXPECT_EQ(views_of(kEngine, 5).frames.test, 1);
  EXPECT_ERROR(views_of(kEngine, 5, {"scene_file.obit=3"}), "did you mean 'scene_file.orbit'?");
  EXPECT_ERROR(views_of(kEngine + "x", 5), "2CylinderEngine.glbx: no such file");
  // What stands in the manifest is the whole recipe.
  const Recipe again = config_from_tree<Recipe>(parse_config(config_to_yaml(many), "manifest"));
  EXPECT_EQ(config_to_yaml(again), config_to_yaml(many));
}

TEST(SceneViews, FileCamerasFirstThenPlacesAroundThem) {
  const auto source = make_scene_source(views_of(kEngine, 12));
  const SceneFile file(kEngine);
  const Camera own = file.camera(0, {});
  const Camera first = source->prepare(0)->scene().camera;
  EXPECT_EQ(first.position.x, own.position.x);
  EXPECT_EQ(first.fov, own.fov);
  EXPECT_EQ(first.lens_radius, 0);
  int thin_lens = 0, blurred = 0;
  for (int64_t i = 1; i < 12; ++i) {
    const auto scene = source->prepare(i);
    const Camera& camera = scene->scene().camera;
    EXPECT_GT(length(camera.position - own.position), 0.01F * length(own.position)) << i;
    EXPECT_GT(camera.depth(file.bounds(0).centre()), 0) << i;
    thin_lens += camera.lens_radius > 0;
    blurred += camera.shutter && camera.close;
    EXPECT_TRUE(scene->scene().sky.has_value()) << "the file has no light of its own";
    int seen = 0;
    for (int p = 0; p < 64; ++p)
      seen += scene
                  ->trace(camera.at(0).ray(
                              {static_cast<float>(p % 8) * 2.5F, static_cast<float>(p / 8) * 2.0F, {}, 0}),
                          0)
                  .has_value();
    EXPECT_GT(seen, 6) << "view " << i;
  }
  EXPECT_GT(thin_lens, 1);
  EXPECT_GT(blurred, 1);
}

TEST(SceneViews, KeepTheConfigurationThatTheyWereMadeWith) {
  Recipe recipe = views_of(kBox, 4, {"scene_file.defocus=0"});
  const auto source = make_scene_source(recipe);
  recipe.scene_file.defocus = 1;
  for (int64_t i = 0; i < 4; ++i) EXPECT_EQ(source->prepare(i)->scene().camera.lens_radius, 0) << i;
}

TEST(SceneViews, FilesWithoutACameraAreFramed) {
  const auto source = make_scene_source(views_of(kBox, 4, {"scene_file.ground=true"}));
  for (int64_t i = 0; i < 4; ++i) {
    const auto scene = source->prepare(i);
    const Camera camera = scene->scene().camera.at(0);
    EXPECT_EQ(scene->scene().objects.size(), 2U) << "the box and the ground";
    const auto middle = scene->trace(camera.ray({10, 8, {}, 0}), 0);
    ASSERT_TRUE(middle);
    EXPECT_EQ(middle->object, 0) << "the box is in the middle of view " << i;
  }
  Bounds bounds = {{-1, -1, -1}, {1, 1, 1}};
  const Camera camera = framing_camera(bounds, 30, 20);
  for (const float x : {-1.0F, 1.0F})
    for (const float y : {-1.0F, 1.0F})
      for (const float z : {-1.0F, 1.0F}) {
        const Vec2 corner = camera.project({x, y, z});
        EXPECT_TRUE(corner.x > 0 && corner.x < 30 && corner.y > 0 && corner.y < 20);
      }
}

TEST(SceneViews, BackgroundFollowsTheFilesLight) {
  const TemporaryFolder folder;
  TestGltf gltf;
  const auto background = [&](const std::vector<std::string>& overrides) {
    const std::string path = gltf.write(folder / "s.gltf").string();
    const Scene scene = make_scene_source(views_of(path, 1, overrides))->prepare(0)->scene();
    return scene.probe ? "probe" : scene.sky ? "sky" : "black";
  };
  EXPECT_STREQ(background({}), "sky");
  EXPECT_STREQ(background({"scene_file.background=black"}), "black");
  gltf.root["materials"][0]["emissiveFactor"] = {1, 1, 1};
  EXPECT_STREQ(background({}), "black");
  EXPECT_STREQ(background({"scene_file.background=sky"}), "sky");
  const std::string picture = "/usr/share/assimp/models/glTF2/BoxTextured-glTF/CesiumLogoFlat.png";
  EXPECT_STREQ(background({"scene_file.probe=" + picture}), "probe");
}

TEST(SceneViews, EmissionIsSeenAsItIsWritten) {
  const TemporaryFolder folder;
  TestGltf gltf;
  gltf.root["materials"][0] = {
      {"emissiveFactor", {1, 0.5, 0.25}},
      {"pbrMetallicRoughness", {{"baseColorFactor", {0, 0, 0, 1}}, {"metallicFactor", 0}}},
      {"extras", {{"ld", {{"kind", "diffuse"}}}}},
      {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 3}}}}}};
  gltf.root["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.5}, {"znear", 0.1}}}}};
  gltf.add_node({{"camera", 0}, {"translation", {0, 0, 2}}});
  const std::string path = gltf.write(folder / "s.gltf").string();
  render_dataset(views_of(path, 1), folder / "data", 0, 1, 1);
  const Image image = read_image(reference_path(folder / "data", frame_name(0)));
  EXPECT_NEAR(image.at(0, 10, 8), 3, 1e-2F);
  EXPECT_NEAR(image.at(1, 10, 8), 1.5F, 1e-2F);
  EXPECT_NEAR(image.at(2, 0, 0), 0.75F, 1e-2F) << "it fills the picture";
  // Twice the exposure, twice the light; an automatic one brings the median luminance to a quarter.
  render_dataset(views_of(path, 1, {"scene_file.exposure=2"}), folder / "twice", 0, 1, 1);
  EXPECT_NEAR(read_image(reference_path(folder / "twice", frame_name(0))).at(0, 10, 8), 6, 2e-2F);
  render_dataset(views_of(path, 1, {"scene_file.exposure=0"}), folder / "automatic", 0, 1, 1);
  const Image exposed = read_image(reference_path(folder / "automatic", frame_name(0)));
  EXPECT_NEAR(luminance({exposed.at(0, 5, 5), exposed.at(1, 5, 5), exposed.at(2, 5, 5)}), 0.25F, 1e-2F);
}

TEST(SceneViews, PiecesEqualTheWholeAndChangedFilesAreRefused) {
  const TemporaryFolder folder;
  TestGltf gltf;
  gltf.animate(0, "translation", {0, 0, 0, 1, 0, 0});
  const std::string path = gltf.write(folder / "s.gltf").string();
  const Recipe recipe = views_of(path, 4, {"scene_file.motion_blur=1"});
  render_dataset(recipe, folder / "whole", 0, 4, 2);
  render_dataset(recipe, folder / "pieces", 2, 3, 1);
  EXPECT_EQ(render_dataset(recipe, folder / "pieces", 0, 4, 3).rendered, 3);
  for (int64_t i = 0; i < 4; ++i)
    EXPECT_EQ(bytes(folder / "whole", frame_name(i)), bytes(folder / "pieces", frame_name(i))) << i;
  gltf.root["materials"][0]["pbrMetallicRoughness"]["roughnessFactor"] = 0.5;
  gltf.write(path);
  EXPECT_ERROR(render_dataset(views_of(path, 4, {"scene_file.motion_blur=1"}), folder / "whole", 0, 4, 2),
               "another recipe");
}

TEST(SequenceDataset, FilesAndManifestOfSequences) {
  const TemporaryFolder folder;
  Recipe recipe;
  recipe.resolution = {17, 12};
  recipe.spp = 1;
  recipe.reference_spp = {2, 2, 2, 1};
  recipe.frames = {4, 0, 2, 0};
  recipe.scenes.variety = "simple";
  recipe.scenes.objects = {5, 6};
  recipe.sequence.length = 2;
  recipe.sequence.noise_instances = 2;
  recipe.half_radiance = true;
  const RenderReport report = render_dataset(recipe, folder / "whole", 0, 6, 2);
  EXPECT_EQ(report.rendered, 6);
  EXPECT_EQ(report.paths, 6 * (2 * (17 * 12 + 9 * 6) + 2 * 17 * 12));
  const Manifest manifest = read_manifest(folder / "whole");
  ASSERT_EQ(manifest.frames.size(), 12U);
  const ManifestFrame& last = manifest.frames[11];
  EXPECT_EQ(last.name, "frame_000005_n1");
  EXPECT_EQ(last.sequence, 2);
  EXPECT_EQ(last.position, 1);
  EXPECT_EQ(last.split, "test");
  EXPECT_EQ(last.index, 5);
  const auto whole = folder / "whole";
  EXPECT_EQ(read_file(reference_path(whole, "frame_000005")),
            read_file(reference_path(whole, "frame_000005_n1")));
  EXPECT_NE(read_file(frame_path(whole, "frame_000005")), read_file(frame_path(whole, "frame_000005_n1")));
  const FrameHeader header = read_frame_header(frame_path(whole, "frame_000005"));
  EXPECT_EQ(header.features, auto_feature_names()) << "with flow";
  EXPECT_EQ(header.info.frame, 5);
  const FrameHeader half = read_frame_header(half_path(whole, "frame_000005_n1"));
  EXPECT_EQ(half.width, 9);
  EXPECT_EQ(half.height, 6);

  render_dataset(recipe, folder / "pieces", 3, 4, 1);
  render_dataset(recipe, folder / "pieces", 0, 6, 1);
  for (const ManifestFrame& frame : manifest.frames)
    EXPECT_EQ(bytes(whole, frame.name), bytes(folder / "pieces", frame.name)) << frame.name;
  EXPECT_EQ(read_file(folder / "whole" / "manifest.json"), read_file(folder / "pieces" / "manifest.json"));
  std::filesystem::remove(frame_path(whole, "frame_000003_n1"));
  std::filesystem::remove(half_path(whole, "frame_000001"));
  EXPECT_EQ(render_dataset(recipe, whole, 0, 6, 2).rendered, 2);
  EXPECT_EQ(bytes(whole, "frame_000003_n1"), bytes(folder / "pieces", "frame_000003_n1"));

  recipe.frames.train = 3;
  EXPECT_ERROR(finish_recipe(recipe, "r.yaml", ""), "a split of 3 frames cuts a sequence of 2");
}

TEST(SequenceDataset, SceneFilesPlayTheirAnimation) {
  const TemporaryFolder folder;
  TestGltf gltf;
  gltf.animate(0, "translation", {0, 0, 0, 24, 0, 0});
  const std::string path = gltf.write(folder / "s.gltf").string();
  const auto source = make_scene_source(views_of(
      path, 3, {"frames.train=3", "frames.test=0", "sequence.length=3", "scene_file.frame_time=0.01"}));
  for (int64_t k = 0; k < 3; ++k) {
    const auto scene = source->prepare(k);
    const Object& square = scene->scene().objects[0];
    EXPECT_NEAR(square.mesh.positions[0].x, -1 + 0.24F * static_cast<float>(k), 1e-4F);
    EXPECT_NEAR(square.motion.translation.x, 0.12F, 1e-4F);
    if (k > 0) {
      EXPECT_NEAR(square.previous.translation.x, -0.24F, 1e-4F);
    }
    EXPECT_TRUE(scene->scene().camera.previous.has_value());
  }
}

TEST(RecipeOptions, SamplingAndGuides) {
  const TemporaryFolder folder;
  const auto first_frame = [&](const std::string& name, const std::vector<std::string>& overrides) {
    render_dataset(views_of(kBox, 1, overrides), folder / name, 0, 1, 1);
    return read_file(frame_path(folder / name, frame_name(0)));
  };
  const std::string plain = first_frame("a", {});
  EXPECT_EQ(plain, first_frame("b", {"sampling=independent", "guides=first_hit"}));
  EXPECT_NE(plain, first_frame("c", {"sampling=low_discrepancy"}));
  EXPECT_ERROR(views_of(kBox, 1, {"sampling=sobol"}), "expected one of independent, low_discrepancy");
  EXPECT_ERROR(views_of(kBox, 1, {"guides=second"}), "expected one of first_hit, through_specular");
}

TEST(LdRenderScene, FromEndToEnd) {
  const TemporaryFolder folder;
  const std::string out = (folder / "data").string();
  const std::vector<std::string> small = {"--scene",
                                          kBox,
                                          "--out",
                                          out,
                                          "--views",
                                          "4",
                                          "resolution=[16,16]",
                                          "spp=2",
                                          "reference_spp.train=4",
                                          "reference_spp.test=4"};
  const ProgramResult result = run_program("ld_render", small);
  EXPECT_EQ(result.exit_code, 0) << result.output;
  EXPECT_EQ(frames_of_split(folder / "data", "train").size(), 3U);
  EXPECT_EQ(frames_of_split(folder / "data", "test").size(), 1U);
  EXPECT_NE(run_program("ld_render", small).output.find("0 frames rendered, 4 were there"),
            std::string::npos);

  expect_failure(run_program("ld_render", {"--scene", kBox, "--recipe", "r.yaml", "--out", out}), 2,
                 {"one of them"});
  expect_failure(run_program("ld_render", {"--recipe", "r.yaml", "--views", "3", "--out", out}), 2,
                 {"--scene"});
  expect_failure(run_program("ld_render", {"--scene", kBox + "x", "--out", out}), 1, {"BoxTextured.glbx"});
  write_file_atomically(folder / "broken.obj", "f 1 2 3\n");
  const std::string none = (folder / "none").string();
  expect_failure(
      run_program("ld_render", {"--scene", (folder / "broken.obj").string(), "--views", "1", "--out", none}),
      1, {"broken.obj"});
  EXPECT_FALSE(std::filesystem::exists(none)) << "a scene that cannot be read leaves nothing behind";
  write_file_atomically(folder / "broken.glb", "glTF and then nothing");
  expect_failure(run_program("ld_render", {"--scene", (folder / "broken.glb").string(), "--out", out}), 1,
                 {"broken.glb", "truncated"});
}

}  // namespace
}  // namespace ld
