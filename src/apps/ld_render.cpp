// Random scenes to training frames: `ld_render --recipe FILE --out DIR [--frames A:B] [key.sub=value ...]`.

#include "apps/app.h"
#include "core/log.h"
#include "core/progress.h"
#include "render/dataset_renderer.h"

int main(int argc, char** argv) {
  std::string recipe_path, folder, range;
  std::vector<std::string> overrides;
  ld::Application app(
      "ld_render",
      "Renders random scenes to frames of samples with references, a data set for training. Frames that "
      "the folder holds already are kept, so running it again finishes what is missing.");
  app.options().add_option("--recipe", recipe_path, "YAML recipe, see data/recipes")->required();
  app.options().add_option("--out", folder, "folder of the data set")->required();
  app.options().add_option("--frames", range,
                           "A:B renders frames A to B - 1 of the recipe only (default: all)");
  app.options().add_option("overrides", overrides, "key.sub=value, on top of the recipe");

  return app.run(argc, argv, [&] {
    const ld::Recipe recipe = ld::read_recipe(recipe_path, overrides, app.seed());
    const auto [begin, end] = ld::parse_frame_range(range, recipe.frame_count());

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
