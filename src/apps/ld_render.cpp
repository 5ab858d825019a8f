// Random scenes, views of a scene file or sequences to training frames:
// `ld_render --recipe FILE | --scene FILE --out DIR [--frames A:B] [key.sub=value ...]`.

#include "apps/app.h"
#include "core/error.h"
#include "core/log.h"
#include "core/progress.h"
#include "render/recipe/contact_sheet.h"
#include "render/recipe/dataset_renderer.h"

namespace {

void report_sheet(const ld::SheetReport& report, const std::string& path, const ld::Application& app) {
  const int64_t rejected = report.drafts - report.scenes;
  std::string faults;
  nlohmann::ordered_json counts = nlohmann::ordered_json::object();
  for (const auto& [fault, count] : report.rejected) {
    faults += fmt::format("{}{} {}", faults.empty() ? ": " : ", ", count, ld::fault_name(fault));
    counts[ld::fault_name(fault)] = count;
  }
  const double share =
      100.0 * static_cast<double>(rejected) / static_cast<double>(std::max<int64_t>(1, report.drafts));
  spdlog::info("{} frames, {} of {} drafts rejected ({:.1f} %{}): {}", report.scenes, rejected, report.drafts,
               share, faults, path);
  app.write_json({{"scenes", report.scenes}, {"drafts", report.drafts}, {"rejected", counts}});
}

}  // namespace

int main(int argc, char** argv) {
  std::string recipe_path, scene, probe, folder, range, preview;
  int64_t views = 0;
  int columns = 8, preview_spp = 16;
  std::vector<std::string> overrides;
  ld::Application app(
      "ld_render",
      "Renders random scenes, or views of a scene file, to frames of samples with references, a data set for "
      "training. Frames that the folder holds already are kept, so running it again finishes what is "
      "missing.");
  app.options().add_option("--recipe", recipe_path, "YAML recipe, as those in data/recipes");
  app.options().add_option(
      "--scene", scene,
      "scene file instead of a recipe: glTF, or what else Assimp reads (docs/rendering.md)");
  app.options().add_option(
      "--probe", probe,
      "with --scene: equirectangular picture (HDR, EXR) as the background (default: that of the file)");
  app.options()
      .add_option(
          "--views", views,
          "with --scene: so many views, the file's cameras first (default: its cameras, at least one)")
      ->check(ld::whole_number_within(1, 1000000));
  app.options().add_option("--out", folder, "folder of the data set; needed unless --preview is there");
  app.options().add_option("--frames", range,
                           "A:B renders frames A to B - 1 of the recipe only (default: all)");
  app.options().add_option("--preview", preview,
                           "PNG to write instead: a contact sheet of the recipe's random scenes");
  app.options()
      .add_option("--columns", columns, "pictures in a row of the contact sheet")
      ->check(ld::whole_number_within(1, 1000))
      ->capture_default_str();
  app.options()
      .add_option("--preview-spp", preview_spp, "paths a pixel of the contact sheet")
      ->check(ld::whole_number_within(1, 65536))
      ->capture_default_str();
  app.options().add_option(
      "overrides", overrides,
      "key.sub=value, on top of the recipe; ld_inspect --keys recipe lists all keys and their defaults");
  app.options().footer(
      "Examples:\n"
      "  ld_render --recipe data/recipes/quick.yaml --out out/data spp=4 resolution=[64,64]\n"
      "  ld_render --scene scene.glb --views 24 --out out/data\n"
      "  ld_render --recipe data/recipes/quick.yaml --preview sheet.png");

  return app.run(argc, argv, [&] {
    if (recipe_path.empty() == scene.empty())
      ld::fail_command_line("expected --recipe FILE or --scene FILE, one of them");
    app.refuse_overwriting({preview}, {recipe_path, scene, probe});
    if (scene.empty() && (views != 0 || !probe.empty()))
      ld::fail_command_line("--views and --probe go with --scene; a recipe has frames and scene_file.probe");
    const ld::Recipe recipe = scene.empty() ? ld::read_recipe(recipe_path, overrides, app.seed())
                                            : ld::scene_recipe(scene, probe, views, overrides, app.seed());
    const auto [begin, end] = ld::frames_of_recipe(range, recipe.frame_count());
    if (folder.empty() == preview.empty())
      ld::fail_command_line("expected --out DIR for a data set, or --preview FILE.png for a contact sheet");
    if (!preview.empty()) {
      report_sheet(ld::render_contact_sheet(recipe, begin, end, columns, preview_spp, preview, app.threads()),
                   preview, app);
      return;
    }

    const ld::RenderReport report = ld::render_dataset(recipe, folder, begin, end, app.threads());

    const double speed = static_cast<double>(report.paths) / std::max(report.seconds, 1e-9);
    spdlog::info("{} frames rendered, {} were there, {} left to do; {:.2f} million paths/s, {} in {}",
                 report.rendered, report.present, report.left, speed / 1e6, ld::duration_text(report.seconds),
                 folder);
    if (report.clamped > 0)
      spdlog::info("{} radiance channels of the samples were beyond half's range and written as 65504",
                   report.clamped);
    app.write_json({{"rendered", report.rendered},
                    {"present", report.present},
                    {"left", report.left},
                    {"paths", report.paths},
                    {"clamped", report.clamped},
                    {"seconds", report.seconds},
                    {"paths_per_second", speed}});
  });
}
