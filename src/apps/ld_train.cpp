// Trains a network, or continues a training: `ld_train --config FILE [key.sub=value ...] --out RUN`.

#include <algorithm>
#include <cmath>

#include "apps/app.h"
#include "core/error.h"
#include "core/log.h"
#include "ops/runtime.h"
#include "training/device.h"
#include "training/run/config_file.h"
#include "training/run/run_folder.h"
#include "training/trainer.h"

int main(int argc, char** argv) {
  std::string config_path, run, command;
  std::vector<std::string> overrides;
  ld::Application app("ld_train", "Trains a denoising network on a data set, or continues a training.");
  app.options().add_option("--config", config_path, "YAML configuration")->required();
  app.options().add_option("--out", run, "run folder: checkpoints, logs, resolved configuration")->required();
  app.options().add_option(
      "overrides", overrides,
      "key.sub=value, on top of the file; ld_inspect --keys train lists all keys and their defaults");
  app.options().footer(
      "Examples:\n"
      "  ld_train --config configs/quick.yaml data.path=out/quickstart/data --out out/run\n"
      "  ld_train --config configs/layer.yaml data.path=DATA network.features=auto run.minutes=60 --out "
      "out/hour");
  for (int i = 0; i < argc; ++i) command += (i > 0 ? " " : "") + ld::shell_word(argv[i]);

  return app.run(argc, argv, [&] {
    app.refuse_overwriting({}, {config_path});
    const ld::ConfigNode tree = ld::read_train_tree(config_path, overrides);
    auto config = ld::config_from_tree<ld::TrainConfig>(tree);
    ld::device_named(config.run.device, ld::place_of(tree, "run", "device"));
    const auto sets_seed = [](const std::string& assignment) { return assignment.rfind("seed=", 0) == 0; };
    if (app.seed() && std::any_of(overrides.begin(), overrides.end(), sets_seed))
      ld::fail_command_line("--seed {} and {} both say the seed; give one of them", *app.seed(),
                            *std::find_if(overrides.begin(), overrides.end(), sets_seed));
    if (app.seed()) config.seed = *app.seed();

    ld::configure_runtime(app.threads());
    const std::unique_ptr<ld::ProcessGroup> group = ld::ProcessGroup::from_environment();
    if (!group->is_root()) spdlog::set_level(spdlog::level::warn);  // rank 0 speaks for all
    ld::Trainer trainer(config, run, {group.get(), command, {}, {}});
    trainer.train();

    if (trainer.total_steps() == 0) return;  // stopped before anything began
    const ld::TrainingState& state = trainer.state();
    std::string best = trainer.verdict();
    if (best.empty())
      best = std::isfinite(state.best_score)
                 ? fmt::format("best validation loss {:.4f} at step {}", state.best_score, state.best_step)
                 : "no validation yet";
    spdlog::info("{} of {} steps done; {}; weights in {}/checkpoints", state.step, trainer.total_steps(),
                 best, run);
    if (!group->is_root()) return;
    if (state.rollbacks > 0)
      spdlog::warn(
          "the training collapsed and went back {} times: the learning rate ended at {:g} of the schedule's",
          state.rollbacks, state.rate_factor());
    app.write_json({{"step", state.step},
                    {"total_steps", trainer.total_steps()},
                    {"skipped", state.skipped},
                    {"rollbacks", state.rollbacks},
                    {"best_score", state.best_score},
                    {"best_step", state.best_step},
                    {"verdict", trainer.verdict()}});
  });
}
