// Finds the model that a scene requires: `ld_tune --data DATA --budget-ms 20 --at 1920x1080 --out MODEL`.

#include <filesystem>

#include "apps/app.h"
#include "apps/output_check.h"
#include "core/log.h"
#include "tuning/tune.h"

namespace {

void declare(CLI::App& app, ld::TuneOptions& options, std::string& at) {
  app.add_option("--data", options.data,
                 "data set: a folder with manifest.json, training and validation splits")
      ->required();
  CLI::Option* budget = app.add_option("--budget-ms", options.requirement.budget_ms,
                                       "find the lowest error within so many milliseconds a frame")
                            ->check(ld::number_within(1e-6, 1e9));
  app.add_option("--target-smape", options.requirement.target_smape,
                 "instead: find the fastest model with this mean SMAPE on the validation split")
      ->check(ld::number_within(1e-6, 1))
      ->excludes(budget);
  app.add_option("--at", at, "WIDTHxHEIGHT of the frames whose time counts (default: that of the data)");
  app.add_option("--samples", options.samples,
                 "samples a pixel, in training and use (default: all that frames have)")
      ->check(ld::whole_number_within(1, 4096));
  app.add_option("--minutes", options.minutes, "of training, all trials together")
      ->check(ld::number_within(1e-3, 1e6))
      ->capture_default_str();
  app.add_option("--out", options.out, "weights to write (.safetensors); a card (.md) comes beside them")
      ->required();
  app.add_option("--work", options.work,
                 "folder of the search, its trials, table and figure (default: OUT.tune)");
  app.add_option("--config", options.config,
                 "training configuration that all candidates share (default: samples_fast)");
  app.add_option("overrides", options.overrides, "key.sub=value, on top of that configuration");
}

}  // namespace

int main(int argc, char** argv) {
  ld::TuneOptions options;
  std::string at;
  ld::Application app("ld_tune",
                      "Finds the network that a scene requires, trains it and says why it is that one.");
  declare(app.options(), options, at);
  app.options().footer(
      "Examples:\n"
      "  ld_tune --data out/quickstart/data --budget-ms 200 --at 960x540 --out out/tuned.safetensors\n"
      "  ld_tune --data out/quickstart/data --target-smape 0.05 --minutes 120 --out out/tuned.safetensors");

  return app.run(argc, argv, [&] {
    if (!options.requirement.budget_ms && !options.requirement.target_smape)
      ld::fail_command_line("give --budget-ms or --target-smape");
    if (!at.empty()) options.at = ld::parse_size(at);
    ld::require_extension("--out", options.out, {".safetensors"});
    ld::require_writable({options.out, app.json_path()});
    app.refuse_overwriting({options.out, options.folder()}, {options.data, options.config});
    options.seed = app.seed();
    options.threads = app.threads();
    const auto result = ld::tune(options);
    if (!result) {
      spdlog::warn(std::filesystem::exists(options.folder()) ? "stopped; the same command goes on from {}"
                                                             : "stopped before {} was begun",
                   options.folder().string());
      return;
    }
    app.write_json(*result);
    spdlog::info("{} written; table and figure in {}", options.out.string(), options.folder().string());
  });
}
