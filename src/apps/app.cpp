#include "apps/app.h"

#include <charconv>
#include <exception>
#include <iostream>

#include "core/error.h"
#include "core/file_identity.h"
#include "core/file_io.h"
#include "core/log.h"
#include "core/signals.h"
#include "core/threads.h"

namespace ld {

Application::Application(std::string name, const std::string& description)
    : name_(std::move(name)), options_(description, name_) {
  options_.set_version_flag("--version", name_ + " " LD_VERSION);
  options_
      .add_option("--threads", threads_,
                  "threads to use (default: OMP_NUM_THREADS, else the CPUs of this process)")
      ->check(whole_number_within(1, 4096));
  options_.add_option("--seed", seed_, "random seed (default: that of the recipe or config, else 1)");
  options_.add_option("--json", json_path_, "also write the result as JSON to this file (default: nowhere)");
}

int Application::run(int argc, char** argv, const std::function<void()>& body) {
  const auto complain = [&](const std::exception& error) {
    std::cerr << name_ << ": " << error.what() << "; see " << name_ << " --help\n";
    return 2;
  };
  try {
    options_.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return error.get_exit_code() == 0 ? options_.exit(error) : complain(error);  // 0: --help, --version
  }
  try {
    init_log(name_);
    install_stop_handler();
    if (threads_ == 0) threads_ = default_threads();
    body();
    return stop_exit_code();
  } catch (const CommandLineError& error) {
    return complain(error);
  } catch (const Error& error) {
    std::cerr << name_ << ": " << error.what() << "\n";
    return error.exit_code();
  } catch (const std::exception& error) {
    std::cerr << name_ << ": " << error.what() << "\n";
    return 1;
  }
}

void Application::refuse_overwriting(std::vector<std::filesystem::path> outputs,
                                     const std::vector<std::filesystem::path>& inputs) const {
  const std::filesystem::path json = json_path_;
  // A folder that is read is read whole: its frames, pictures and manifest are inputs, too.
  if (std::filesystem::exists(json) && (json.extension() == ".exr" || json.filename() == "manifest.json"))
    for (const std::filesystem::path& input : inputs)
      if (std::filesystem::is_directory(input) &&
          FileIdentity(std::filesystem::absolute(json).parent_path()) == FileIdentity(input))
        fail_usage("--json {} is a file of the input {}; choose another name or folder", json.string(),
                   input.string());
  outputs.push_back(json);
  ld::refuse_overwriting(outputs, inputs);
}

void Application::write_json(const nlohmann::ordered_json& json) const {
  if (!json_path_.empty()) write_file_atomically(json_path_, json.dump(2) + "\n");
}

std::optional<double> number_in(const std::string& text, double least, double most) {
  double value = 0;
  const char* const end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || stop != end || !(value >= least && value <= most)) return std::nullopt;
  return value;
}

CLI::Validator number_within(double least, double most) {
  return CLI::Validator(
      [least, most](const std::string& text) {
        return number_in(text, least, most)
                   ? std::string()
                   : fmt::format("expected a number from {:g} to {:g}, found '{}'", least, most, text);
      },
      fmt::format("in [{:g} - {:g}]", least, most));
}

CLI::Validator whole_number_within(int64_t least, int64_t most) {
  return CLI::Validator(
      [least, most](const std::string& text) {
        int64_t value = 0;
        const char* const end = text.data() + text.size();
        const auto [stop, error] = std::from_chars(text.data(), end, value);
        // With a zero before it the parser would take it for octal.
        const bool plain = text.size() == 1 || text.front() != '0';
        return error == std::errc() && stop == end && plain && value >= least && value <= most
                   ? std::string()
                   : fmt::format("expected a whole number from {} to {}, found '{}'", least, most, text);
      },
      fmt::format("in [{} - {}]", least, most));
}

}  // namespace ld
