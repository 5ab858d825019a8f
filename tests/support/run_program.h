// Runs one of the project's programs as a user would and collects what it said.
#pragma once

#include <fcntl.h>
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/file_io.h"
#include "tests/support/temporary_folder.h"

namespace ld {

/// A program that runs in the background, its standard output and error going to one file.
class RunningProgram {
 public:
  /// `name` of one of ours, or the path of another. `environment`: variables that it finds besides those of
  /// the test.
  RunningProgram(const std::string& name, std::vector<std::string> arguments,
                 const std::map<std::string, std::string>& environment = {}) {
    arguments.insert(arguments.begin(), (std::filesystem::path(LD_BIN_DIR) / name).string());
    std::vector<char*> argv;
    for (std::string& argument : arguments) argv.push_back(argument.data());
    argv.push_back(nullptr);
    const std::string log = (folder_ / "output").string();
    process_ = fork();
    if (process_ == 0) {
      const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
      dup2(file, STDOUT_FILENO);
      dup2(file, STDERR_FILENO);
      for (const auto& [variable, value] : environment) setenv(variable.c_str(), value.c_str(), 1);
      execv(argv[0], argv.data());
      _exit(127);
    }
  }

  void signal(int number) const { kill(process_, number); }

  /// The exit code, or -N when signal N ended the program.
  int wait() {
    int status = 0;
    waitpid(process_, &status, 0);
    output_ = read_file(folder_ / "output");
    return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
  }
  const std::string& output() const { return output_; }

 private:
  TemporaryFolder folder_;
  pid_t process_ = 0;
  std::string output_;
};

struct ProgramResult {
  int exit_code;
  std::string output;
};

inline ProgramResult run_program(const std::string& name, const std::vector<std::string>& arguments) {
  RunningProgram program(name, arguments);
  const int code = program.wait();
  return {code, program.output()};
}

/// The program must fail with this code and one line that holds every one of the texts.
inline void expect_failure(const ProgramResult& result, int exit_code,
                           const std::vector<std::string>& texts) {
  EXPECT_EQ(result.exit_code, exit_code) << result.output;
  std::string last_line = result.output.substr(0, result.output.find_last_not_of('\n') + 1);
  last_line = last_line.substr(last_line.rfind('\n') + 1);
  for (const std::string& text : texts)
    EXPECT_NE(last_line.find(text), std::string::npos) << "expected '" << text << "' in:\n" << result.output;
}

}  // namespace ld
