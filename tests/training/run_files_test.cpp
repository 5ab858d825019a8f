// Schedules, tables and notes of a run: what needs no LibTorch.
#include <gtest/gtest.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

#include "core/file_io.h"
#include "core/pi.h"
#include "tests/support/expect_error.h"
#include "tests/support/full_disk.h"
#include "tests/support/temporary_folder.h"
#include "training/run/event_log.h"
#include "training/run/pace.h"
#include "training/run/run_folder.h"
#include "training/run/schedule.h"
#include "training/run/training_state.h"

namespace ld {
namespace {

OptimizerConfig schedule(const std::string& name) {
  OptimizerConfig config;
  config.learning_rate = 1;
  config.schedule = name;
  return config;
}

TEST(Schedule, Constant) {
  EXPECT_EQ(learning_rate(schedule("constant"), 0, 0, 1000), 1);
  EXPECT_EQ(learning_rate(schedule("constant"), 999, 50, 1000), 1);
}

TEST(Schedule, StepsDownByEpochs) {
  OptimizerConfig config = schedule("step");
  config.step_epochs = 10;
  EXPECT_EQ(learning_rate(config, 99, 9, 1000), 1);
  EXPECT_EQ(learning_rate(config, 100, 10, 1000), 0.5);
  EXPECT_EQ(learning_rate(config, 399, 39, 1000), 0.125);
  config.step_factor = 0.1;
  EXPECT_DOUBLE_EQ(learning_rate(config, 200, 20, 1000), 0.01);
}

TEST(Schedule, Cosine) {
  const OptimizerConfig config = schedule("cosine");
  EXPECT_EQ(learning_rate(config, 0, 0, 1000), 1);
  EXPECT_NEAR(learning_rate(config, 250, 0, 1000), 0.5 + std::sqrt(0.125), 1e-12);
  EXPECT_NEAR(learning_rate(config, 500, 0, 1000), 0.5, 1e-12);
  EXPECT_NEAR(learning_rate(config, 999, 0, 1000), 0, 1e-5);
}

// Chaitanya et al. 2017, section 5.3.
TEST(Schedule, InverseRootRampsUpTenfoldAndFallsWithTheRootOfTheEpochs) {
  OptimizerConfig config = schedule("inverse_root");
  config.learning_rate = 1e-3;
  EXPECT_NEAR(learning_rate(config, 0, 0, 1000), 1e-4, 1e-15);
  EXPECT_NEAR(learning_rate(config, 5, 5, 1000), 1e-3 / std::sqrt(10.0), 1e-15);
  EXPECT_NEAR(learning_rate(config, 10, 10 - 1e-9, 1000), 1e-3, 1e-12);
  EXPECT_NEAR(learning_rate(config, 10, 10, 1000), 1e-3, 1e-15);
  EXPECT_NEAR(learning_rate(config, 40, 40, 1000), 5e-4, 1e-15);
  EXPECT_NEAR(learning_rate(config, 500, 500, 1000), 1e-3 / std::sqrt(50.0), 1e-15);
  EXPECT_GT(learning_rate(config, 1, 0.1, 1000), learning_rate(config, 0, 0, 1000)) << "step by step";
}

TEST(Schedule, OneCycleIsPyTorchs) {
  // torch.optim.lr_scheduler.OneCycleLR(max_lr=1, total_steps=101): it rises over 29.3 steps.
  const OptimizerConfig config = schedule("one_cycle");
  EXPECT_NEAR(learning_rate(config, 0, 0, 101), 0.04, 1e-12);
  const double rising = 0.04 + 0.96 * 0.5 * (1 - std::cos(M_PI * 10 / 29.3));
  EXPECT_NEAR(learning_rate(config, 10, 0, 101), rising, 1e-9);
  const double falling = 4e-6 + (1 - 4e-6) * 0.5 * (1 + std::cos(M_PI * (60 - 29.3) / (100 - 29.3)));
  EXPECT_NEAR(learning_rate(config, 60, 0, 101), falling, 1e-9);
  EXPECT_NEAR(learning_rate(config, 100, 0, 101), 4e-6, 1e-12);
  for (int64_t total = 1; total < 8; ++total)
    for (int64_t step = 0; step < total; ++step) {
      const double rate = learning_rate(config, step, 0, total);
      EXPECT_TRUE(rate > 0 && rate <= 1) << step << " of " << total << ": " << rate;
    }
}

TEST(Schedule, OneCycleHasBoundsOfItsOwn) {
  OptimizerConfig config = schedule("one_cycle");
  config.one_cycle = {0.5, 0.2, 0.01};
  EXPECT_NEAR(learning_rate(config, 0, 0, 101), 0.2, 1e-12);
  EXPECT_NEAR(learning_rate(config, 49, 0, 101), 1, 1e-3);  // the peak is at 49.5
  EXPECT_LT(learning_rate(config, 51, 0, 101), 1);
  EXPECT_NEAR(learning_rate(config, 100, 0, 101), 0.01, 1e-12);
  config.one_cycle = {0, 1, 0};  // no rise, down to nothing
  EXPECT_EQ(learning_rate(config, 0, 0, 101), 1);
  EXPECT_EQ(learning_rate(config, 100, 0, 101), 0);
  config.one_cycle = {1, 1e-9, 1};  // a rise alone
  EXPECT_NEAR(learning_rate(config, 0, 0, 101), 1e-9, 1e-12);
  EXPECT_EQ(learning_rate(config, 100, 0, 101), 1);
  for (int64_t total = 1; total < 8; ++total)
    for (int64_t step = 0; step < total; ++step) {
      const double rate = learning_rate(config, step, 0, total);
      EXPECT_TRUE(rate > 0 && rate <= 1) << step << " of " << total << ": " << rate;
    }
}

TEST(Schedule, OneCyclesDefaultsAreTheBitsOfPyTorchsDivisors) {
  const auto along = [](double from, double to, double progress) {
    return to + 0.5 * (from - to) * (1 + std::cos(kPi * progress));
  };
  for (const double highest : {0.005, 0.003, 0.002, 1e-3, 7e-4, 0.1, 1.0 / 3, 10.0}) {
    OptimizerConfig config = schedule("one_cycle");
    config.learning_rate = highest;
    const double first = highest / 25, last = first / 1e4;  // div_factor, final_div_factor
    for (int64_t step = 0; step < 1000; ++step) {
      const auto now = static_cast<double>(step);
      EXPECT_EQ(learning_rate(config, step, 0, 1000),
                step < 299 ? along(first, highest, now / 299) : along(highest, last, (now - 299) / 700))
          << highest << " " << step;
    }
  }
}

TEST(Optimizer, OnlyAdamwDecaysWeights) {
  OptimizerConfig config;
  config.weight_decay = 0.01;
  EXPECT_ERROR(check_optimizer(config), "set optimizer.name=adamw");
  config.name = "adamw";
  EXPECT_NO_THROW(check_optimizer(config));
}

TEST(Schedule, WarmUp) {
  OptimizerConfig config = schedule("cosine");
  config.warmup_steps = 4;
  EXPECT_NEAR(learning_rate(config, 0, 0, 1000000), 0.25, 1e-6);
  EXPECT_NEAR(learning_rate(config, 2, 0, 1000000), 0.75, 1e-6);
  EXPECT_NEAR(learning_rate(config, 4, 0, 1000000), 1, 1e-6);
  config.schedule = "one_cycle";
  EXPECT_ERROR(check_optimizer(config), "a rise of its own");
  config.warmup_steps = 0;
  EXPECT_NO_THROW(check_optimizer(config));
}

TEST(Schedule, IsAsLongAsStepsOrEpochsSay) {
  TrainConfig config;
  config.epochs = 10;
  config.optimizer.accumulate = 4;
  EXPECT_EQ(schedule_steps(config, 7), 17);
  config.run.minutes = 1;
  EXPECT_EQ(schedule_steps(config, 7), 0);
  config.steps = 5;
  EXPECT_EQ(schedule_steps(config, 7), 5);
}

TEST(Pace, AsManyStepsAsThereIsTimeFor) {
  Pace pace;
  pace.step = 0.5;
  EXPECT_EQ(steps_within(pace, 100), 200);
  EXPECT_EQ(steps_within(pace, 99.9), 199);
  EXPECT_EQ(steps_within(pace, 0), 1);
  EXPECT_EQ(steps_within(pace, -5), 1);
  pace.first_step = 2;
  pace.first_steps = 10;
  EXPECT_EQ(steps_within(pace, 100), 10 + 160);
  EXPECT_EQ(steps_within(pace, 10), 5);
  pace.validation = 3;
  pace.validate_every = 40;
  pace.checkpoint = 1;
  pace.checkpoint_every = 20;
  EXPECT_EQ(seconds_of(pace, 40), 20 + 15 + 3 + 2);  // a validation is saved with the checkpoint of its step
  pace.checkpoint_every = 30;
  EXPECT_EQ(seconds_of(pace, 40), 20 + 15 + 3 + 2 + 1);
  for (const double seconds : {50.0, 777.0, 86400.0}) {
    const int64_t steps = steps_within(pace, seconds);
    EXPECT_LE(seconds_of(pace, steps), seconds);
    EXPECT_GT(seconds_of(pace, steps + 1), seconds);
  }
}

TEST(Pace, WhatHappensOnceDoesNotCount) {
  EXPECT_EQ(typical({0.5}), 0.5);
  EXPECT_EQ(typical({1, 3}), 2);
  EXPECT_EQ(typical({0.5, 0.5, 90, 0.5, 0.5, 0.5, 0.5, 0.5}), 0.5);
  EXPECT_EQ(typical({0, 2, 0, 2, 0, 2, 0, 2}), 1);  // two workers deliver together
}

TEST(State, KeepsEveryBit) {
  TrainingState state;
  state.step = 123;
  state.optimizer_steps = 120;
  state.skipped = 3;
  state.skipped_in_a_row = 1;
  state.loss_sum = 0.1 + 0.2;
  state.loss_count = 7;
  state.validation_due = true;
  state.best_score = 1.0 / 3;
  state.best_step = 100;
  state.crops_per_step = 8;
  state.rollbacks = 2;
  state.watch = {{0.1, 1e-300, 1.0 / 3}, {0.7, 5e-324}, 3, 100, 75};
  state.dataset = "0123456789abcdef";
  const std::string text = state_to_json(state);
  const TrainingState read = state_from_json(text, "state.json");
  EXPECT_EQ(state_to_json(read), text);
  EXPECT_EQ(read.loss_sum, state.loss_sum);
  EXPECT_EQ(read.best_score, state.best_score);
  EXPECT_EQ(read.rollbacks, 2);
  EXPECT_EQ(read.watch.losses, state.watch.losses);
  EXPECT_EQ(read.watch.medians, state.watch.medians);
  EXPECT_EQ(read.watch.raised, 3);
  EXPECT_EQ(read.watch.window_begin, 100);
  EXPECT_EQ(read.watch.calm_step, 75);
  EXPECT_TRUE(std::isinf(state_from_json(state_to_json({}), "state.json").best_score));
  EXPECT_ERROR(state_from_json("{\"step\": 5}", "state.json"), "begin a new run");
  EXPECT_ERROR(state_from_json("{\"version\": 2, \"step\": 5}", "state.json"), "optimizer_steps");
  EXPECT_ERROR(state_from_json("[]", "state.json"), "state.json");
  for (const char* step : {"1e260", "1.5", "18446744073709551615", "\"5\"", "null"})
    EXPECT_ERROR(state_from_json(fmt::format("{{\"version\": 2, \"step\": {}}}", step), "state.json"),
                 fmt::format("state.json: \"step\" is {}, expected a whole number",
                             nlohmann::json::parse(step).dump()));
}

TEST(State, CountersBelowZeroAreRefused) {
  const auto good = nlohmann::json::parse(state_to_json({}));
  for (const char* key : {"step", "optimizer_steps", "skipped", "skipped_in_a_row", "loss_count", "best_step",
                          "crops_per_step", "rollbacks"}) {
    auto json = good;
    json[key] = -3;
    EXPECT_ERROR(state_from_json(json.dump(), "state.json"),
                 fmt::format("state.json: \"{}\" is -3, expected a whole number from 0", key));
  }
  for (const char* key : {"raised", "window_begin", "calm_step"}) {
    auto json = good;
    json["watch"][key] = INT64_MIN;
    EXPECT_ERROR(state_from_json(json.dump(), "state.json"),
                 fmt::format("state.json: \"{}\" is {}, expected a whole number from 0", key, INT64_MIN));
  }
  EXPECT_NO_THROW(state_from_json(good.dump(), "state.json"));
}

TEST(State, OfAnEarlierProgramKnowsNoWatch) {
  auto json = nlohmann::json::parse(state_to_json({}));
  json.erase("watch");
  json.erase("rollbacks");
  json["step"] = 7;
  const TrainingState read = state_from_json(json.dump(), "state.json");
  EXPECT_EQ(read.step, 7);
  EXPECT_EQ(read.rollbacks, 0);
  EXPECT_TRUE(read.watch.medians.empty());
}

TEST(EventLog, OtherColumnsAreAnotherTable) {
  const TemporaryFolder folder;
  const std::string old = "step,loss\n5,0.5\n";
  write_file_atomically(folder / "m.csv", old);
  EventLog(folder / "m.csv", {"loss", "rate"}, 10).write(10, {{"loss", 0.25}, {"rate", 1}});
  EXPECT_EQ(read_file(folder / "m.1.csv"), old);
  EXPECT_EQ(read_file(folder / "m.csv"), "step,loss,rate\n10,0.25,1\n");
  EventLog(folder / "m.csv", {"rate"}, 10).write(15, {{"rate", 1}});
  EXPECT_EQ(read_file(folder / "m.1.csv"), old);
  EXPECT_EQ(read_file(folder / "m.2.csv"), "step,loss,rate\n10,0.25,1\n");
  EXPECT_EQ(read_file(folder / "m.csv"), "step,rate\n15,1\n");
}

TEST(EventLog, DropsTheRowsThatAResumedRunWritesAgain) {
  const TemporaryFolder folder;
  {
    EventLog log(folder / "m.csv", {"loss", "rate"}, 0);
    log.write(5, {{"loss", 0.5}});
    log.write(10, {{"loss", 0.25}, {"rate", 1e-3}});
    log.write(15, {{"rate", 1}});
  }
  EventLog log(folder / "m.csv", {"loss", "rate"}, 10);
  log.write(15, {{"loss", 0.125}});
  EXPECT_EQ(read_file(folder / "m.csv"), "step,loss,rate\n5,0.5,\n10,0.25,0.001\n15,0.125,\n");
}

TEST(EventLog, RowsWaitForRoom) {
  const TemporaryFolder folder;
  EventLog log(folder / "m.csv", {"loss"}, 0);
  log.write(1, {{"loss", 0.5}});
  const std::string before = read_file(folder / "m.csv");
  {
    const FileSizeLimit limit(before.size() + 3);  // room for half a row
    log.write(2, {{"loss", 0.25}});
    log.write(3, {{"loss", 0.125}});
    EXPECT_FALSE(log.flush());
    EXPECT_EQ(read_file(folder / "m.csv"), before);
  }
  EXPECT_TRUE(log.flush());
  EXPECT_EQ(read_file(folder / "m.csv"), before + "2,0.25\n3,0.125\n");
}

TEST(RunFolder, TellsHowToDoTheRunAgain) {
  const TemporaryFolder folder;
  TrainConfig config;
  config.seed = 7;
  RunOrigin origin;
  origin.command = "ld_train --config a.yaml";
  origin.threads = 2;
  write_origin(folder.path(), config, origin);
  const auto json = nlohmann::json::parse(read_file(folder / "run.json"));
  EXPECT_EQ(json.at("seed"), 7);
  EXPECT_EQ(json.at("command"), "ld_train --config a.yaml");
  EXPECT_NE(json.at("reproduce").get<std::string>().find("config.yaml --threads 2 --out NEW_RUN"),
            std::string::npos);
  EXPECT_EQ(json.at("program").get<std::string>().rfind("ld_train 0.", 0), 0u);
}

TEST(RunFolder, WordsForShells) {
  EXPECT_EQ(shell_word("data.path=out/a_b-1.yaml"), "data.path=out/a_b-1.yaml");
  EXPECT_EQ(shell_word("a b"), "'a b'");
  EXPECT_EQ(shell_word("it's"), "'it'\\''s'");
  EXPECT_EQ(shell_word(""), "''");
  EXPECT_EQ(shell_word("$HOME"), "'$HOME'");
}

}  // namespace
}  // namespace ld
