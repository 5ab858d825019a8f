#include "training/run/run_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <cstring>
#include <sstream>

#include "core/error.h"
#include "core/file_io.h"

namespace ld {

std::string fixed_configuration(TrainConfig config) {
  RunConfig run;
  run.minutes = config.run.minutes;
  config.run = run;
  config.watch = WatchConfig{};
  config.data.cache = DataConfig{}.cache;
  config.data.cache_megabytes = DataConfig{}.cache_megabytes;
  config.data.workers = DataConfig{}.workers;
  config.data.batch = DataConfig{}.batch;
  config.optimizer.accumulate = OptimizerConfig{}.accumulate;
  return config_to_yaml(config);
}

RunLock::RunLock(const std::filesystem::path& run) {
  make_folder(run);
  descriptor_ = open((run / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
  if (descriptor_ >= 0 && flock(descriptor_, LOCK_EX | LOCK_NB) == 0) return;
  const int why = errno;
  if (descriptor_ >= 0) close(descriptor_);
  if (why == EWOULDBLOCK)
    fail("{}: another ld_train is training into this run folder; wait for it or choose another --out",
         run.string());
  fail("cannot lock {}: {}", (run / ".lock").string(), std::strerror(why));
}

RunLock::~RunLock() {
  close(descriptor_);
}

void claim_run_folder(const std::filesystem::path& run, const TrainConfig& config) {
  const std::filesystem::path path = run / "config.yaml";
  if (std::filesystem::exists(path)) {
    const auto stored = config_from_tree<TrainConfig>(read_config(path));
    std::istringstream old_lines(fixed_configuration(stored)), new_lines(fixed_configuration(config));
    std::string before, now;
    while (std::getline(old_lines, before), std::getline(new_lines, now)) {
      const auto trimmed = [](const std::string& line) {
        return line.substr(std::min(line.find_first_not_of(' '), line.size()));
      };
      if (before != now)
        fail_usage(
            "{} holds a run with another configuration: there '{}', here '{}'; choose another --out, or "
            "change it back to continue that run",
            run.string(), trimmed(before), trimmed(now));
    }
  }
  write_file_atomically(path, config_to_yaml(config));
}

int64_t stored_steps(const std::filesystem::path& run) {
  const std::filesystem::path path = run / "config.yaml";
  return std::filesystem::exists(path) ? config_from_tree<TrainConfig>(read_config(path)).steps : 0;
}

std::string shell_word(const std::string& argument) {
  const bool plain = !argument.empty() && std::all_of(argument.begin(), argument.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 ||
           std::string("_-+=./:,@%").find(c) != std::string::npos;
  });
  if (plain) return argument;
  std::string quoted = "'";
  for (const char c : argument) quoted += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return quoted + "'";
}

std::string reproducing_command(const std::filesystem::path& run, const std::string& out, int threads) {
  return fmt::format("ld_train --config {} --threads {} --out {}", shell_word((run / "config.yaml").string()),
                     threads, shell_word(out));
}

void write_origin(const std::filesystem::path& run, const TrainConfig& config, const RunOrigin& origin) {
  nlohmann::ordered_json json;
  json["program"] = "ld_train " LD_VERSION;
  json["libtorch"] = origin.libtorch;
  json["blas_kernels"] = origin.blas;
  json["compiler"] = __VERSION__;
  json["threads"] = origin.threads;
  json["processes"] = origin.processes;
  json["seed"] = config.seed;
  json["dataset"] = origin.dataset;
  json["parameters"] = origin.parameters;
  json["total_steps"] = origin.total_steps;
  json["command"] = origin.command;
  json["reproduce"] = reproducing_command(run, "NEW_RUN", origin.threads);
  write_file_atomically(run / "run.json", json.dump(2) + "\n");
}

}  // namespace ld
