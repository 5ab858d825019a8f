#include "core/process/child_process.h"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <exception>
#include <thread>
#include <utility>

#include "core/error.h"
#include "core/signals.h"

namespace ld {
namespace {

constexpr int kCame = 42;  // exit code of a child whose work came to its end; no sanitizer or library has it

[[noreturn]] void run(const std::function<void()>& work) {
  try {
    work();
  } catch (const std::exception&) {
    // The caller does the same work again and meets the same exception where it can be reported.
    _exit(kCame);
  }
  _exit(kCame);
}

constexpr int kNotStarted = 127;  // as a shell has it

/// Between fork and exec of a program with threads: nothing here takes memory or a lock.
[[noreturn]] void become(char* const* arguments, int log, pid_t parent) {
  setpgid(0, 0);
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (getppid() != parent) _exit(kNotStarted);  // which ended before it could tell us
  dup2(log, STDOUT_FILENO);
  dup2(log, STDERR_FILENO);
  execv(arguments[0], arguments);
  _exit(kNotStarted);
}

}  // namespace

int run_child(const std::vector<std::string>& arguments, const std::filesystem::path& log) {
  if (access(arguments.at(0).c_str(), X_OK) != 0)
    fail("cannot start {}: {}", arguments[0], std::strerror(errno));
  std::vector<char*> words;
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  const int file = open(log.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (file < 0) fail("cannot write {}: {}", log.string(), std::strerror(errno));
  const pid_t parent = getpid(), child = fork();
  if (child == 0) become(words.data(), file, parent);
  const int why = errno;
  close(file);
  if (child < 0) fail("cannot start {}: {}", arguments[0], std::strerror(why));
  bool told = false;
  int status = 0;
  for (pid_t ended = 0; ended == 0; ended = waitpid(child, &status, WNOHANG)) {
    if (stop_requested() && !std::exchange(told, true)) kill(child, SIGTERM);
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

bool survives_in_a_child(const std::function<void()>& work) {
  const pid_t child = fork();
  if (child < 0) fail("cannot start a process: {}", std::strerror(errno));
  if (child == 0) run(work);
  int status = 0;
  while (waitpid(child, &status, 0) < 0) {
    if (errno != EINTR) fail("cannot wait for a process: {}", std::strerror(errno));
    if (stop_requested()) kill(child, SIGTERM);
  }
  return WIFEXITED(status) && WEXITSTATUS(status) == kCame;
}

}  // namespace ld
