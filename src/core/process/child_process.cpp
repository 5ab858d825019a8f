#include "core/process/child_process.h"

#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>

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

}  // namespace

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
