// Recipes, data sets that are finished in pieces, and ld_render as its users meet it.
#include "render/recipe/dataset_renderer.h"

#include <gtest/gtest.h>

#include <chrono>
#include <csignal>
#include <sstream>
#include <thread>

#include "core/file_io.h"
#include "frame/frame_file.h"
#include "frame/manifest.h"
#include "frame/picture_place.h"
#include "metrics/metric.h"
#include "render/trace/image_renderer.h"
#include "tests/support/expect_error.h"
#include "tests/support/run_program.h"
#include "tests/support/temporary_folder.h"

namespace ld {
namespace {

Recipe small_recipe() {
  Recipe recipe;
  recipe.resolution = {20, 16};
  recipe.spp = 2;
  recipe.reference_spp = {4, 4, 8, 1};
  recipe.frames = {3, 1, 2, 0};
  recipe.scenes.variety = "simple";  // full scenes take half a second each to draft
  return recipe;
}

std::string bytes(const std::filesystem::path& folder, int64_t frame) {
  return read_file(frame_path(folder, frame_name(frame))) +
         read_file(reference_path(folder, frame_name(frame)));
}

TEST(Recipe, ReadsFilesOverridesAndSeed) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "r.yaml",
                        "resolution: [64, 32]\nframes: {train: 5, test: 2}\nscenes: {indoor: 0.25}\n");
  const Recipe recipe = read_recipe(folder / "r.yaml", {"frames.validation=1", "reference_spp.test=99"}, 7);
  EXPECT_EQ(recipe.width(), 64);
  EXPECT_EQ(recipe.height(), 32);
  EXPECT_EQ(recipe.seed, 7U);
  EXPECT_EQ(recipe.scenes.indoor, 0.25);
  EXPECT_EQ(recipe.split(4), "train");
  EXPECT_EQ(recipe.split(5), "validation");
  EXPECT_EQ(recipe.split(6), "test");
  EXPECT_EQ(recipe.reference_spp_of(7), 99);
  // What is stored in the manifest reads back to the same.
  const Recipe again = config_from_tree<Recipe>(parse_config(config_to_yaml(recipe), "manifest"));
  EXPECT_EQ(config_to_yaml(again), config_to_yaml(recipe));
}

TEST(Recipe, NamesWhatIsWrong) {
  const TemporaryFolder folder;
  const auto read = [&](const std::string& text) {
    write_file_atomically(folder / "r.yaml", text);
    return read_recipe(folder / "r.yaml", {}, {});
  };
  EXPECT_ERROR(read("resolution: [64]"), "expected two numbers");
  EXPECT_ERROR(read("spp: 8\nrefrence_spp: {train: 1}"),
               "r.yaml:2: unknown key 'refrence_spp'; did you mean 'reference_spp'?");
  EXPECT_ERROR(read("reference_spp: {train: 0}"), "reference_spp.train: expected a whole number from 1");
  EXPECT_ERROR(read("scenes: {objects: [9, 3]}"), "swap");
  EXPECT_ERROR(read("frames: {train: 0, validation: 0, test: 0}"), "at least one frame");
  EXPECT_ERROR(read_recipe(folder / "none.yaml", {}, {}), "none.yaml");
  EXPECT_ERROR(read("path_regularisation: 1.5"), "path_regularisation: expected a number from 0 to 1");
  EXPECT_ERROR(read("indirect_clamp: -1"), "indirect_clamp: expected a number from 0");
  EXPECT_ERROR(read("reference_estimator: median"), "reference_estimator: expected one of");
  EXPECT_ERROR(read("reference_estimator: robust"), "even number of at least 6");
  EXPECT_ERROR(read("reference_parts: 3"), "expected 1 or an even number, found 3");
  EXPECT_ERROR(read("reference_parts: 12"),
               "reference_spp.train: expected a multiple of reference_parts (12), found 1024");
}

TEST(Recipe, FrameRanges) {
  using Range = std::pair<int64_t, int64_t>;
  EXPECT_EQ(frames_of_recipe("", 9), Range(0, 9));
  EXPECT_EQ(frames_of_recipe("2:5", 9), Range(2, 5));
  EXPECT_EQ(frames_of_recipe("2:", 9), Range(2, 9));
  EXPECT_EQ(frames_of_recipe(":3", 9), Range(0, 3));
  for (const char* wrong : {"3", "a:b", "5:5", "0:10", "-1:3", "1:2x"})
    EXPECT_ERROR(frames_of_recipe(wrong, 9), "--frames");
}

TEST(Recipe, ShippedRecipesAreValid) {
  for (const char* name : {"quick", "small", "medium", "paper"}) {
    const Recipe recipe = read_recipe(std::string(LD_SOURCE_DIR) + "/data/recipes/" + name + ".yaml", {}, {});
    EXPECT_EQ(recipe.spp, 8) << name;
    EXPECT_GE(recipe.frames.test, 6) << name;
  }
  const Recipe paper = read_recipe(std::string(LD_SOURCE_DIR) + "/data/recipes/paper.yaml", {}, {});
  EXPECT_EQ(paper.frames.train, 4352);
  EXPECT_EQ(paper.frames.validation, 128);
  EXPECT_EQ(paper.reference_spp.train, 4096);
  EXPECT_EQ(paper.width(), 256);

  const Recipe benchmark = read_recipe(std::string(LD_SOURCE_DIR) + "/data/recipes/benchmark.yaml", {}, {});
  EXPECT_EQ(benchmark.frame_count(), 12);
  EXPECT_EQ(benchmark.split(0), "test");
  EXPECT_EQ(benchmark.reference_spp_of(0), 4096);
  EXPECT_EQ(benchmark.reference_estimator, "robust");
  int defocus = 0, motion_blur = 0, rooms = 0;
  for (uint32_t frame = 0; frame < 12; ++frame) {
    const auto prepared =
        prepare_random_scene(benchmark.scenes, benchmark.seed, frame, benchmark.width(), benchmark.height());
    const Scene& scene = prepared->scene();
    rooms += scene.name.rfind("indoor", 0) == 0 ? 1 : 0;
    defocus += scene.camera.lens_radius > 0 ? 1 : 0;
    motion_blur += scene.camera.shutter ? 1 : 0;
  }
  EXPECT_EQ(rooms, 6);
  EXPECT_EQ(defocus, 6);
  EXPECT_EQ(motion_blur, 6);
}

TEST(DatasetRenderer, PiecesEqualTheWholeBitForBit) {
  const TemporaryFolder folder;
  const Recipe recipe = small_recipe();
  const RenderReport report = render_dataset(recipe, folder / "whole", 0, 6, 2);
  EXPECT_EQ(report.rendered, 6);
  EXPECT_EQ(report.paths, 20 * 16 * (6 * 2 + 4 * 4 + 2 * 8));
  render_dataset(recipe, folder / "pieces", 4, 6, 1);
  render_dataset(recipe, folder / "pieces", 1, 2, 3);
  const RenderReport rest = render_dataset(recipe, folder / "pieces", 0, 6, 1);
  EXPECT_EQ(rest.rendered, 3);
  EXPECT_EQ(rest.present, 3);
  for (int64_t frame = 0; frame < 6; ++frame)
    EXPECT_EQ(bytes(folder / "whole", frame), bytes(folder / "pieces", frame)) << frame;
  EXPECT_EQ(read_file(folder / "whole" / "manifest.json"), read_file(folder / "pieces" / "manifest.json"));
  EXPECT_EQ(frames_of_split(folder / "whole", "train").size(), 3U);
  EXPECT_EQ(frames_of_split(folder / "whole", "test")[0].index, 4);
  EXPECT_EQ(render_dataset(recipe, folder / "whole", 0, 6, 2).present, 6);

  // Each frame's scene is its own: no two frames look alike.
  for (int64_t frame = 1; frame < 6; ++frame)
    EXPECT_NE(bytes(folder / "whole", 0), bytes(folder / "whole", frame));
}

TEST(DatasetRenderer, DamagedFramesAreRenderedAgain) {
  const TemporaryFolder folder;
  const Recipe recipe = small_recipe();
  render_dataset(recipe, folder / "data", 0, 2, 2);
  const std::string before = bytes(folder / "data", 1);
  write_file_atomically(reference_path(folder / "data", frame_name(1)), "not an EXR");
  const RenderReport report = render_dataset(recipe, folder / "data", 0, 2, 2);
  EXPECT_EQ(report.rendered, 1);
  EXPECT_EQ(bytes(folder / "data", 1), before);
}

TEST(DatasetRenderer, AnotherRecipesFolderIsAnError) {
  const TemporaryFolder folder;
  Recipe recipe = small_recipe();
  render_dataset(recipe, folder / "data", 0, 1, 2);
  recipe.seed = 2;
  EXPECT_ERROR(render_dataset(recipe, folder / "data", 1, 2, 2),
               "holds frames of another seed (1 there, 2 here)");
  EXPECT_FALSE(std::filesystem::exists(frame_path(folder / "data", frame_name(1))));
}

TEST(DatasetRenderer, FoldersFromBeforeARecipeKeyAreFinished) {
  const TemporaryFolder folder;
  Recipe recipe = small_recipe();
  Manifest before;
  before.seed = recipe.seed;
  std::istringstream lines(config_to_yaml(recipe));
  for (std::string line; std::getline(lines, line);)
    if (line.rfind("path_", 0) != 0 && line.rfind("indirect_", 0) != 0 &&
        line.rfind("reference_estimator", 0) != 0 && line.rfind("reference_parts", 0) != 0)
      before.recipe += line + "\n";
  ASSERT_NE(before.recipe, config_to_yaml(recipe));
  add_to_manifest(folder / "data", before);
  EXPECT_EQ(render_dataset(recipe, folder / "data", 0, 1, 2).rendered, 1);
  EXPECT_EQ(read_manifest(folder / "data").recipe, before.recipe);
  EXPECT_EQ(render_dataset(recipe, folder / "data", 0, 1, 2).present, 1);
  recipe.path_regularisation = 0.2;
  EXPECT_ERROR(render_dataset(recipe, folder / "data", 1, 2, 2), "another recipe");
}

TEST(DatasetRenderer, ReferencesInPartsKnowTheirFloor) {
  const TemporaryFolder folder;
  Recipe recipe = small_recipe();
  recipe.reference_spp = {24, 24, 24, 1};
  render_dataset(recipe, folder / "plain", 0, 1, 1);
  recipe.reference_parts = 6;
  recipe.reference_estimator = "robust";
  recipe.path_regularisation = 0.3;
  recipe.indirect_clamp = 5;
  render_dataset(recipe, folder / "one", 0, 2, 1);
  render_dataset(recipe, folder / "three", 0, 2, 3);
  const auto floor_of = [&](const char* set) {
    const std::filesystem::path path = reference_path(folder / set, frame_name(0));
    return read_reference(path, read_place(path), "the frame").floor;
  };
  EXPECT_TRUE(floor_of("plain").empty());
  const ReferenceFloor floor = floor_of("one");
  EXPECT_EQ(floor.size(), metrics().size());
  EXPECT_GT(floor.at("relmse"), 0);
  EXPECT_LT(floor.at("ssim"), 1);
  for (int64_t frame = 0; frame < 2; ++frame)
    EXPECT_EQ(bytes(folder / "one", frame), bytes(folder / "three", frame));
}

TEST(DatasetRenderer, FilesHoldWhatWasRendered) {
  const TemporaryFolder folder;
  const Recipe recipe = small_recipe();
  render_dataset(recipe, folder.path(), 0, 1, 2);
  const auto scene = prepare_random_scene(recipe.scenes, recipe.seed, 0, recipe.width(), recipe.height());
  RenderSettings settings;
  settings.seed = recipe.seed;
  settings.spp = 2;
  const Frame rendered = *render_samples(*scene, settings);
  Faults faults;
  const Frame read = read_frame(frame_path(folder.path(), frame_name(0)), mh20_feature_names(), faults);
  EXPECT_FALSE(faults.any());
  ASSERT_EQ(read.samples.size(), rendered.samples.size());
  for (size_t i = 0; i < read.samples.size(); ++i)
    ASSERT_NEAR(read.samples[i], std::min(rendered.samples[i], 65504.0F),
                1e-3F * std::abs(rendered.samples[i]) + 1e-6F);
  EXPECT_EQ(read.info.scene, scene->scene().name);
  EXPECT_EQ(read.info.seed, recipe.seed);
  EXPECT_NEAR(read.info.depth_scale, median_depth(rendered), 1e-3F * median_depth(rendered));
  EXPECT_EQ(read_image(reference_path(folder.path(), frame_name(0))).width, 20);
}

TEST(LdRender, StopsOnASignalAndContinues) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "r.yaml",
                        "resolution: [32, 32]\nspp: 1\nreference_spp: {train: 4}\nframes: {train: 4, "
                        "validation: 0, test: 0}\n");
  const std::string recipe = (folder / "r.yaml").string(), out = (folder / "data").string();
  ASSERT_EQ(run_program("ld_render", {"--recipe", recipe, "--out", (folder / "whole").string()}).exit_code,
            0);

  for (const auto& [number, code] : {std::pair<int, int>{SIGINT, 130}, {SIGTERM, 143}}) {
    // Half a minute of work a frame, so that the signal comes in the middle of one.
    const std::string slow = (folder / std::to_string(code)).string();
    RunningProgram program("ld_render", {"--recipe", recipe, "--out", slow, "reference_spp.train=20000"});
    // The manifest is there just before the first path.
    for (int i = 0; i < 500 && !std::filesystem::exists(std::filesystem::path(slow) / "manifest.json"); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    std::this_thread::sleep_for(std::chrono::milliseconds(300));
    const auto start = std::chrono::steady_clock::now();
    program.signal(number);
    ASSERT_EQ(program.wait(), code) << program.output();
    EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(3));
    EXPECT_NE(program.output().find("4 left to do"), std::string::npos) << program.output();
    for (const auto& entry : std::filesystem::directory_iterator(slow))
      EXPECT_NE(entry.path().extension(), ".exr") << "a half-written " << entry.path();
  }

  ASSERT_EQ(run_program("ld_render", {"--recipe", recipe, "--out", out, "--frames", "1:2", "--threads", "1"})
                .exit_code,
            0);
  const ProgramResult rest = run_program("ld_render", {"--recipe", recipe, "--out", out, "--threads", "3"});
  EXPECT_EQ(rest.exit_code, 0);
  EXPECT_NE(rest.output.find("3 frames rendered, 1 were there"), std::string::npos) << rest.output;
  for (int64_t frame = 0; frame < 4; ++frame) EXPECT_EQ(bytes(folder / "whole", frame), bytes(out, frame));
}

TEST(LdRender, SaysWhatIsWrong) {
  const TemporaryFolder folder;
  write_file_atomically(folder / "r.yaml", "frames: {train: 2}\n");
  const std::string recipe = (folder / "r.yaml").string(), out = (folder / "data").string();
  expect_failure(run_program("ld_render", {"--out", out}), 2, {"--recipe"});
  expect_failure(run_program("ld_render", {"--recipe", recipe + "x", "--out", out}), 1, {"r.yamlx"});
  expect_failure(run_program("ld_render", {"--recipe", recipe, "--out", out, "frames.trian=3"}), 2,
                 {"command line", "frames.trian", "frames.train"});
  expect_failure(run_program("ld_render", {"--recipe", recipe, "--out", out, "--frames", "0:999"}), 2,
                 {"--frames 0:999"});
  expect_failure(run_program("ld_render", {"--recipe", recipe, "--out", out, "spp=many"}), 2,
                 {"spp", "whole number"});
  EXPECT_FALSE(std::filesystem::exists(out)) << "a wrong command line writes nothing";
}

}  // namespace
}  // namespace ld
