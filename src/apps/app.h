// What every program shares: the common options, one place that turns exceptions into exit codes, JSON
// output.
#pragma once

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/error.h"

namespace ld {

/// A wrong command line that only the program can tell: run() adds where its options are explained.
class CommandLineError : public UsageError {
 public:
  using UsageError::UsageError;
};

template <class... Args>
[[noreturn]] void fail_command_line(fmt::format_string<Args...> format, Args&&... args) {
  throw CommandLineError(fmt::format(format, std::forward<Args>(args)...));
}

/// Options are declared on `options()`, then run() parses and calls the body:
///   Application app("ld_render", "Random scenes to training frames.");
///   app.options().add_option("--out", out, "folder to fill")->required();
///   return app.run(argc, argv, [&] { ... });
class Application {
 public:
  Application(std::string name, const std::string& description);

  CLI::App& options() { return options_; }
  int threads() const { return threads_; }                     // --threads, else default_threads()
  std::optional<uint64_t> seed() const { return seed_; }       // --seed
  const std::string& json_path() const { return json_path_; }  // --json

  /// Exit codes: 0 done, 1 failure while running, 2 wrong command line or config, 130 and 143 after SIGINT
  /// and SIGTERM. Errors are one line on standard error.
  int run(int argc, char** argv, const std::function<void()>& body);

  /// Throws UsageError when one of the outputs, or the file of --json, is one of the inputs
  /// (core/file_identity.h). Every program that writes calls it before any work.
  void refuse_overwriting(std::vector<std::filesystem::path> outputs,
                          const std::vector<std::filesystem::path>& inputs) const;

  /// Writes the machine-readable result to --json (nothing without it).
  void write_json(const nlohmann::ordered_json& json) const;

 private:
  std::string name_;
  CLI::App options_;
  int threads_ = 0;
  std::optional<uint64_t> seed_;
  std::string json_path_;
};

/// The text as a number from `least` to `most`; nothing where it is none, as NaN.
std::optional<double> number_in(const std::string& text, double least, double most);

/// Such a number.
CLI::Validator number_within(double least, double most);

/// The same of a whole number.
CLI::Validator whole_number_within(int64_t least, int64_t most);

/// An option that may be given several times, one value each, so that it never takes a positional argument
/// for its own.
inline CLI::Option* repeated(CLI::Option* option) {
  return option->take_all()->expected(1)->allow_extra_args(false);
}

}  // namespace ld
