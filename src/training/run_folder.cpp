#include "training/run_folder.h"

#include <sstream>

#include "core/error.h"
#include "core/file_io.h"

namespace ld {
namespace {

/// What may not change, as text: everything but the pauses and what only costs time, memory or disk.
std::string fixed_part(TrainConfig config) {
  config.run = RunConfig{};
  config.data.cache = DataConfig{}.cache;
  config.data.cache_megabytes = DataConfig{}.cache_megabytes;
  config.data.workers = DataConfig{}.workers;
  return config_to_yaml(config);
}

}  // namespace

void claim_run_folder(const std::filesystem::path& run, const TrainConfig& config) {
  const std::filesystem::path path = run / "config.yaml";
  if (std::filesystem::exists(path)) {
    const auto stored = config_from_tree<TrainConfig>(read_config(path));
    std::istringstream old_lines(fixed_part(stored)), new_lines(fixed_part(config));
    std::string before, now;
    while (std::getline(old_lines, before), std::getline(new_lines, now)) {
      const auto trimmed = [](const std::string& line) {
        return line.substr(std::min(line.find_first_not_of(' '), line.size()));
      };
      if (before != now)
        fail_usage(
            "{} holds a run with another configuration: there '{}', here '{}'; choose another --out, or "
            "change it "
            "back to continue that run",
            run.string(), trimmed(before), trimmed(now));
    }
  }
  write_file_atomically(path, config_to_yaml(config));
}

}  // namespace ld
